// SPDX-License-Identifier: Apache-2.0
#include "server/app/closure/known_scans.h"

#include <algorithm>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "server/app/closure/judging_lease.h"

namespace enfilade::server {
namespace {

constexpr int kMaxSessions = 20;  // the latest

bool IsUnmapped(const storage::Session& session) {
  return session.state == storage::SessionState::kRecording || session.state == storage::SessionState::kFinished;
}

// Where a keyframe's scan was taken.
struct Viewpoint {
  SessionId session;
  std::int64_t sequence = 0;  // of the scan
  PoseWithCovariance T_map_robot;
};

absl::StatusOr<std::optional<storage::StoredDoorReport>> FindPassage(const KnownScansScope& scope,
                                                                     const SessionId& session) {
  ENFILADE_ASSIGN_OR_RETURN(const auto reports,
                            scope.stores.verdicts.ReadReports(JudgingLease::Context(), scope.site, session));
  const auto found = std::find_if(reports.begin(), reports.end(), [](const storage::StoredDoorReport& stored) {
    return stored.report.kind == sensor::DoorReport::Kind::kPassage;
  });
  return found == reports.end() ? std::nullopt : std::optional(*found);
}

void DropTail(std::vector<slam::SlamNode>& nodes, double length) {
  double dropped = 0.0;
  while (!nodes.empty() && dropped < length) {
    const slam::SlamNode last = nodes.back();
    nodes.pop_back();
    if (!nodes.empty()) dropped += Between(last.T_map_node, nodes.back().T_map_node).translation().norm();
  }
}

// The keyframes that were certainly taken in the session's own map.
absl::Status AddInside(const KnownScansScope& scope, const storage::Session& session,
                       std::vector<Viewpoint>& viewpoints) {
  ENFILADE_ASSIGN_OR_RETURN(std::vector<slam::SlamNode> nodes,
                            scope.stores.mappings.ListKeyframes(JudgingLease::Context(), session.site, session.id));
  ENFILADE_ASSIGN_OR_RETURN(const auto left, FindPassage(scope, session.id));
  if (left) std::erase_if(nodes, [&](const slam::SlamNode& node) { return node.time >= left->report.door_time; });
  const bool is_door_known = left ? left->judged : session.state != storage::SessionState::kRecording;
  if (!is_door_known) DropTail(nodes, scope.options.locate_tail);
  for (const slam::SlamNode& node : nodes)
    viewpoints.push_back({session.id, node.sequence, {node.T_map_node, node.covariance}});
  return absl::OkStatus();
}

// The keyframes that a session which entered the map took beyond the door; the door's anchors say where that is.
absl::Status AddEntering(const KnownScansScope& scope, const closure::DoorVerdict& verdict,
                         std::vector<Viewpoint>& viewpoints) {
  const graph::LinkPoint* door = verdict.link_point ? scope.graph.FindLinkPoint(*verdict.link_point) : nullptr;
  if (door == nullptr) return absl::OkStatus();
  const auto session = scope.stores.sessions.Get(JudgingLease::Context(), scope.site, verdict.session);
  if (absl::IsNotFound(session.status())) return absl::OkStatus();
  ENFILADE_RETURN_IF_ERROR(session.status());
  const graph::Anchor* from = session->map ? door->FindAnchor(*session->map) : nullptr;
  const graph::Anchor* to = door->FindAnchor(*verdict.entered_map);
  if (from == nullptr || to == nullptr) return absl::OkStatus();
  ENFILADE_ASSIGN_OR_RETURN(const auto report, FindPassage(scope, session->id));
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<slam::SlamNode> nodes,
                            scope.stores.mappings.ListKeyframes(JudgingLease::Context(), session->site, session->id));
  for (const slam::SlamNode& node : nodes) {
    if (!report || node.time < report->report.door_time) continue;
    const PoseWithCovariance T_door_robot{Between(from->T_map_place, node.T_map_node), Eigen::Matrix3d::Zero()};
    viewpoints.push_back({session->id, node.sequence, Compose({to->T_map_place, to->covariance}, T_door_robot)});
  }
  return absl::OkStatus();
}

using ChosenViewpoints = std::map<SessionId, std::map<std::int64_t, const Viewpoint*>>;  // by session and sequence

// locate_scans of them at most, evenly chosen.
ChosenViewpoints Choose(const KnownScansScope& scope, const std::vector<Viewpoint>& viewpoints) {
  ChosenViewpoints chosen;
  const std::size_t count = std::min(static_cast<std::size_t>(scope.options.locate_scans), viewpoints.size());
  for (std::size_t i = 0; i < count; ++i) {
    const Viewpoint& one = viewpoints[i * viewpoints.size() / count];
    chosen[one.session][one.sequence] = &one;
  }
  return chosen;
}

absl::StatusOr<std::vector<closure::PlacedScan>> ReadScans(const KnownScansScope& scope,
                                                           const ChosenViewpoints& chosen) {
  std::vector<closure::PlacedScan> scans;
  for (const auto& [session, places] : chosen) {
    std::vector<std::int64_t> sequences;
    for (const auto& [sequence, place] : places) sequences.push_back(sequence);
    ENFILADE_ASSIGN_OR_RETURN(std::vector<sensor::Record> records,
                              scope.stores.records.ReadEach(JudgingLease::Context(), scope.site, session, sequences));
    for (sensor::Record& record : records) {
      auto* scan = std::get_if<sensor::LaserScan>(&record.payload);
      if (scan != nullptr) scans.push_back({std::move(*scan), places.at(record.sequence)->T_map_robot});
    }
  }
  return scans;
}

// Grounds with the same digest are the same: a record never changes, and sites have no sessions in common.
std::string DigestOf(const SiteId& site, const ChosenViewpoints& chosen, const std::vector<Pose2>& doors) {
  Sha256Stream digest;
  const auto add_numbers = [&](const double* numbers, std::size_t count) {
    digest.Add({reinterpret_cast<const char*>(numbers), count * sizeof(double)});
  };
  const auto add_pose = [&](const Pose2& pose) {
    const double numbers[] = {pose.x, pose.y, pose.yaw};
    add_numbers(numbers, 3);
  };
  digest.Add(site.value());
  for (const auto& [session, places] : chosen) {
    digest.Add("/" + session.value());
    for (const auto& [sequence, place] : places) {
      digest.Add("/" + std::to_string(sequence) + ":");
      add_pose(place->T_map_robot.pose);
      add_numbers(place->T_map_robot.covariance.data(), 9);
    }
  }
  digest.Add("/doors:");
  for (const Pose2& door : doors) add_pose(door);
  return digest.Finish();
}

absl::StatusOr<std::shared_ptr<const closure::SeenGround>> ReadGround(const KnownScansScope& scope, const MapId& map,
                                                                      const ChosenViewpoints& chosen) {
  if (chosen.empty()) return nullptr;
  const std::vector<Pose2> doors = DoorsOf(scope.graph, map);
  const std::string digest = DigestOf(scope.site, chosen, doors);
  if (auto known = scope.grounds.Find(digest)) return known;
  ENFILADE_ASSIGN_OR_RETURN(std::vector<closure::PlacedScan> scans, ReadScans(scope, chosen));
  auto ground = std::make_shared<const closure::SeenGround>(closure::RemoveHitsThroughDoors(std::move(scans), doors));
  scope.grounds.Keep(digest, ground);
  return ground;
}

absl::StatusOr<std::vector<storage::Session>> ListSessions(const KnownScansScope& scope, const MapId& map) {
  return scope.stores.sessions.List(JudgingLease::Context(), scope.site, {.robot = {}, .map = map, .state = {}},
                                    kMaxSessions, std::nullopt);
}

absl::StatusOr<std::vector<Viewpoint>> ListViewpoints(const KnownScansScope& scope, const MapId& map,
                                                      const std::vector<storage::Session>& sessions,
                                                      const Pose2& T_map_place, double reach) {
  ENFILADE_ASSIGN_OR_RETURN(const auto entries,
                            scope.stores.verdicts.ListInto(JudgingLease::Context(), scope.site, map, kMaxSessions));
  std::vector<Viewpoint> viewpoints;
  for (const storage::Session& session : sessions) ENFILADE_RETURN_IF_ERROR(AddInside(scope, session, viewpoints));
  for (const closure::DoorVerdict& verdict : entries) {
    ENFILADE_RETURN_IF_ERROR(AddEntering(scope, verdict, viewpoints));
  }
  std::erase_if(viewpoints, [&](const Viewpoint& one) {
    return Between(T_map_place, one.T_map_robot.pose).translation().norm() > reach;
  });
  return viewpoints;
}

// KnownScans or ScansAround.
template <typename Known>
void NoteUnfinished(const std::vector<storage::Session>& sessions, Known& known) {
  for (const storage::Session& session : sessions) {
    known.recording = known.recording || session.state == storage::SessionState::kRecording;
    known.mapping = known.mapping || (IsUnmapped(session) && session.state != storage::SessionState::kRecording);
  }
}

}  // namespace

std::vector<Pose2> DoorsOf(const graph::GraphSnapshot& graph, const MapId& map) {
  std::vector<Pose2> doors;
  for (const graph::LinkPoint* link_point : graph.ListLinkPointsIn(map)) {
    const graph::Anchor* anchor = link_point->FindAnchor(map);
    if (anchor != nullptr && !link_point->is_candidate()) doors.push_back(anchor->T_map_place);
  }
  return doors;
}

absl::StatusOr<KnownScans> ReadKnownScans(const KnownScansScope& scope, const MapId& map,
                                          const PoseWithCovariance& predicted) {
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<storage::Session> sessions, ListSessions(scope, map));
  KnownScans known;
  NoteUnfinished(sessions, known);
  if (!closure::IsSureEnoughForScans(predicted, scope.options)) return known;
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<Viewpoint> viewpoints,
                            ListViewpoints(scope, map, sessions, predicted.pose, scope.options.locate_reach));
  ENFILADE_ASSIGN_OR_RETURN(known.ground, ReadGround(scope, map, Choose(scope, viewpoints)));
  return known;
}

absl::StatusOr<ScansAround> ReadScansAround(const KnownScansScope& scope, const MapId& map, const Pose2& T_map_place,
                                            double reach) {
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<storage::Session> sessions, ListSessions(scope, map));
  ScansAround around;
  NoteUnfinished(sessions, around);
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<Viewpoint> viewpoints,
                            ListViewpoints(scope, map, sessions, T_map_place, reach));
  ENFILADE_ASSIGN_OR_RETURN(around.scans, ReadScans(scope, Choose(scope, viewpoints)));
  return around;
}

}  // namespace enfilade::server
