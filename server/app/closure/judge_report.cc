// SPDX-License-Identifier: Apache-2.0
#include "server/app/closure/judge_report.h"

#include <utility>
#include <variant>

#include "core/base/status_macros.h"
#include "core/base/uuid.h"
#include "core/closure/decide.h"
#include "core/closure/scan_location.h"
#include "server/app/closure/evidence_gatherer.h"
#include "server/app/closure/evidence_keeper.h"

namespace enfilade::server {
namespace {

// What is known before any evidence has been gathered.
absl::Status ReadScene(const DoorClosureStores& stores, const ReportToJudge& report, JudgedReport& judged) {
  const storage::Session& session = report.session;
  closure::DoorKnowledge& knowledge = judged.knowledge;
  if (session.map) {
    ENFILADE_ASSIGN_OR_RETURN(const storage::Map map,
                              stores.maps.Get(JudgingLease::Context(), session.site, *session.map));
    knowledge.map = {.id = map.id, .level = map.level, .environment = map.environment};
  }
  if (session.state == storage::SessionState::kFailed) knowledge.mapping_error = session.error;
  if (!knowledge.map) return absl::OkStatus();
  ENFILADE_ASSIGN_OR_RETURN(judged.scene, SessionScene::Load(stores, session, report.stored, knowledge.options));
  const SessionScene& scene = *judged.scene;
  knowledge.T_map_door = scene.DoorPose();
  knowledge.T_map_robot = scene.PoseAt(knowledge.report.time);
  closure::AddRide(knowledge);
  if (knowledge.mapping_error || !knowledge.T_map_door || !knowledge.T_map_robot) {
    if (knowledge.report.kind == sensor::DoorReport::Kind::kPassage) {
      knowledge.by_odometry = scene.GuessByOdometry();
      judged.T_odom_robot = scene.OdometryAt(knowledge.report.time);
    }
    return absl::OkStatus();
  }
  if (knowledge.report.kind == sensor::DoorReport::Kind::kCandidate) {
    knowledge.has_views = scene.HasViews(SightingWindow(knowledge));
    return absl::OkStatus();
  }
  knowledge.T_door_robot = scene.RobotFromDoor();
  knowledge.points_behind_door =
      closure::PointsBehindDoor(scene.ScansBetween(knowledge.report.door_time, knowledge.report.time),
                                knowledge.T_map_door->pose, knowledge.T_map_robot->pose);
  judged.T_odom_robot = scene.OdometryAt(knowledge.report.time);
  return absl::OkStatus();
}

bool IsPassageToCompare(const closure::DoorKnowledge& knowledge) {
  return knowledge.report.kind == sensor::DoorReport::Kind::kPassage && knowledge.T_map_door && knowledge.T_map_robot &&
         !knowledge.mapping_error;
}

}  // namespace

absl::StatusOr<JudgedReport> JudgeReport(const DoorClosureStores& stores, const JudgingLease& lease,
                                         const closure::DoorClosureOptions& options, SeenGrounds& grounds,
                                         std::shared_ptr<const SiteGraph> graph, const ReportToJudge& report) {
  JudgedReport judged;
  judged.session = report.session.id;
  judged.sequence = report.stored.sequence;
  judged.graph = std::move(graph);
  closure::DoorKnowledge& knowledge = judged.knowledge;
  knowledge.graph = &judged.graph->graph();
  knowledge.world_index = {.positions = &judged.graph->placed.positions(),
                           .unplaced_maps = judged.graph->placed.ListUnplacedMaps(*knowledge.graph)};
  knowledge.options = options;
  knowledge.report = report.stored.report;
  knowledge.redundant = report.redundant;
  knowledge.waited = report.waited;
  knowledge.new_link_point = LinkPointId(NewUuid());
  knowledge.new_map = MapId(NewUuid());
  ENFILADE_RETURN_IF_ERROR(ReadScene(stores, report, judged));

  std::optional<EvidenceGatherer> gatherer;
  if (IsPassageToCompare(knowledge)) {
    gatherer.emplace(stores, lease, *judged.scene, grounds, knowledge);
    ENFILADE_RETURN_IF_ERROR(gatherer->ReadRobotViews());
  }
  closure::DoorStep step = closure::Decide(knowledge);
  while (!std::holds_alternative<closure::DoorJudgement>(step)) {
    ENFILADE_RETURN_IF_ERROR(gatherer->Gather(step));
    step = closure::Decide(knowledge);
  }
  judged.judgement = std::get<closure::DoorJudgement>(std::move(step));
  if (gatherer) {
    judged.compared_records = gatherer->used_records();
    if (const std::string faults = gatherer->Faults(); !faults.empty()) judged.judgement.reason += "; " + faults;
  }
  return judged;
}

}  // namespace enfilade::server
