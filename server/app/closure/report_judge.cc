// SPDX-License-Identifier: Apache-2.0
#include "server/app/closure/report_judge.h"

#include <utility>

#include "core/base/environment.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/base/uuid.h"
#include "core/closure/known_places.h"
#include "server/app/closure/door_evidence.h"
#include "server/app/closure/passage_judge.h"

namespace enfilade::server {
namespace {

// It cannot be judged. After a passage a new map begins that nothing joins.
void NotJudged(const std::optional<storage::Map>& map, const storage::StoredDoorReport& stored,
               const closure::DoorClosureOptions& options, std::string why, storage::DoorChange& change) {
  change.verdict.decision = closure::DoorDecision::kNotJudged;
  change.verdict.reason = std::move(why);
  if (stored.report.kind != sensor::DoorReport::Kind::kPassage) return;
  change.new_map = MapBehind(map, &stored.report, options);
  change.verdict.entered_map = change.new_map->id;
  change.verdict.reason += "; a new map begins that nothing joins";
}

void JudgeSighting(const closure::DoorClosureOptions& options, const SiteGraph& graph, const SessionScene& scene,
                   const storage::Map& map, const sensor::DoorReport& report, const PoseWithCovariance& T_map_robot,
                   storage::DoorChange& change) {
  const std::vector<closure::KnownPlace> known =
      closure::FindSighted(graph.graph().ListLinkPoints(), map.id, T_map_robot, options);
  closure::DoorVerdict& verdict = change.verdict;
  if (!known.empty()) {
    verdict.decision = closure::DoorDecision::kCandidateKnown;
    verdict.link_point = known.front().link_point->id;
    verdict.reason = known.front().reason;
    return;
  }
  storage::StoredLinkPoint candidate;
  candidate.site = map.site;
  candidate.point.id = LinkPointId(NewUuid());
  candidate.point.kind = report.place;
  candidate.point.anchors = {{map.id, T_map_robot.pose, T_map_robot.covariance}};
  const TimeNs window = DurationOf(options.image_window);
  change.evidence = EvidenceAt(
      scene, candidate.point.id, map.id, report.door_time, report.door_time - window, report.door_time + window,
      [&scene](TimeNs time) -> std::optional<Pose2> {
        const auto pose = scene.PoseAt(time);
        return pose ? std::optional<Pose2>(pose->pose) : std::nullopt;
      },
      options, verdict.evidence);
  verdict.decision = closure::DoorDecision::kCandidateMade;
  verdict.link_point = candidate.point.id;
  verdict.reason = change.evidence.empty() ? "no place is known there; neither images nor clouds were recorded near it"
                                           : "no place is known there";
  change.new_link_point = std::move(candidate);
}

}  // namespace

storage::NewMap MapBehind(const std::optional<storage::Map>& from, const sensor::DoorReport* report,
                          const closure::DoorClosureOptions& options) {
  storage::NewMap map;
  map.id = MapId(NewUuid());
  map.name_prefix = options.map_name;
  if (from) {
    map.level = from->level;
    map.environment = from->environment;
  }
  if (report != nullptr && report->entered_level) map.level = *report->entered_level;
  if (report != nullptr && report->entered_environment) {
    map.environment =
        *report->entered_environment == Environment::kOutdoor ? Environment::kOutdoor : Environment::kIndoor;
  }
  map.slam_profile = map.environment == Environment::kOutdoor ? options.outdoor_profile : options.indoor_profile;
  return map;
}

ReportJudge::ReportJudge(const DoorClosureStores& stores, const closure::DoorClosureOptions& options,
                         std::shared_ptr<const SiteGraph> graph, std::function<absl::Status()> go_on)
    : stores_(stores), options_(options), graph_(std::move(graph)), go_on_(std::move(go_on)) {}

absl::StatusOr<ReportJudge::Judgement> ReportJudge::Judge(const storage::CallContext& context,
                                                          const storage::Session& session,
                                                          const storage::StoredDoorReport& stored,
                                                          const std::set<LinkPointId>& excluded, double waited) const {
  const sensor::DoorReport& report = stored.report;
  Judgement judgement;
  storage::DoorChange& change = judgement.change;
  change.verdict.session = session.id;
  change.verdict.sequence = stored.sequence;
  change.verdict.graph_version = graph_->graph().version();
  std::optional<storage::Map> map;
  if (session.map) {
    ENFILADE_ASSIGN_OR_RETURN(map, stores_.maps.Get(context, session.site, *session.map));
  }
  const auto not_judged = [&](std::string why) {
    NotJudged(map, stored, options_, std::move(why), change);
    return judgement;
  };
  if (!map) return not_judged("the session was only recorded");
  if (session.state == storage::SessionState::kFailed) return not_judged("mapping failed: " + session.error);
  ENFILADE_ASSIGN_OR_RETURN(const SessionScene scene, SessionScene::Load(stores_, context, session, stored, options_));
  const std::optional<PoseWithCovariance> T_map_door = scene.DoorPose();
  const std::optional<PoseWithCovariance> T_map_robot = scene.PoseAt(report.time);
  if (!T_map_door || !T_map_robot) return not_judged("nothing was mapped when the robot was at the door");
  if (report.kind == sensor::DoorReport::Kind::kCandidate) {
    JudgeSighting(options_, *graph_, scene, *map, report, *T_map_door, change);
    return judgement;
  }
  StoredViews views(stores_, session.site, options_, go_on_);
  ENFILADE_ASSIGN_OR_RETURN(judgement.wait_for, JudgePassage(context,
                                                             {.stores = stores_,
                                                              .options = options_,
                                                              .graph = *graph_,
                                                              .scene = scene,
                                                              .report = report,
                                                              .map = *map,
                                                              .T_map_door = *T_map_door,
                                                              .T_map_robot = *T_map_robot,
                                                              .excluded = excluded,
                                                              .waited = waited,
                                                              .go_on = go_on_},
                                                             views, change));
  change.verdict.T_odom_robot = scene.OdometryAt(report.time);
  if (const std::string faults = views.Faults(); !faults.empty()) change.verdict.reason += "; " + faults;
  return judgement;
}

}  // namespace enfilade::server
