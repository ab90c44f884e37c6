// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/environment.h"
#include "core/base/ids.h"
#include "core/base/time.h"
#include "core/geometry/pose2.h"
#include "core/graph/graph_snapshot.h"
#include "core/rearrange/rearrangement.h"

namespace enfilade::rearrange {

// A keyframe of a session.
struct Keyframe {
  std::int64_t sequence = 0;  // of its record in the session's log
  TimeNs time = 0;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  // m, in the map's frame
};

// A session as part of a map.
struct SessionInMap {
  SessionId id = {};
  bool mapped = true;                    // false: still recording or being mapped
  std::vector<Keyframe> keyframes = {};  // in the order of the log; PlanMerge does not need them
};

// A map with all its sessions.
struct MapContent {
  MapId id = {};
  std::string display_name = {};
  int level = 0;
  Environment environment = Environment::kIndoor;
  std::string slam_profile = {};
  std::vector<SessionInMap> sessions = {};
};

// Up to where the graph is sure of the pose between two maps: standard deviations at the link point that leads from one
// to the other, the position's in its least certain direction.
struct MergeOptions {
  double max_translation_sigma = 1.0;  // m
  double max_yaw_sigma = 0.15;         // rad
};

struct MergeRequest {
  MapContent kept = {};
  MapContent merged = {};
  std::optional<Pose2> T_kept_merged = {};  // unset: by the graph
  MergeOptions options = {};
};

// Makes one map of two that are one room. `kept` stays, unless `merged` is the root, which carries the world frame:
// then their roles are exchanged. Link points between the two go, as there is no door; those that lead on keep their
// other anchors; two that become one place are joined to one, the one of the map that stays. INVALID_ARGUMENT: a map
// with itself, across levels or environments, a pose that is not finite. FAILED_PRECONDITION: no link points join the
// maps and no pose is given, or the graph is not sure of it; a session of the map that goes is not mapped. NOT_FOUND:
// the graph does not have one of the maps.
absl::StatusOr<Rearrangement> PlanMerge(const MergeRequest& request, const graph::GraphSnapshot& graph);

struct SplitRequest {
  MapContent map = {};
  std::vector<SessionId> leaving = {};  // whole sessions
  std::vector<SessionCut> cuts = {};    // what is behind a cut leaves, too
  MapSeed seed = {};                    // of the map that they get; its frame is that of `map`
  LinkPointId link_point = {};          // of the new link point between the two
};

// Takes sessions out of a map into a new one. A link point (an opening) joins both where their keyframes are nearest to
// each other; each other link point goes with the map whose keyframes are nearest to it. NOT_FOUND: a session that is
// not in the map. FAILED_PRECONDITION: nothing or everything leaves, a session is not mapped, or there are no keyframes
// on both sides of a cut.
absl::StatusOr<Rearrangement> PlanSplit(const SplitRequest& request, const graph::GraphSnapshot& graph);

}  // namespace enfilade::rearrange
