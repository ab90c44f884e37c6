// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>

#include "core/base/time.h"
#include "core/geometry/pose2.h"
#include "core/slam/matching/motion_model.h"
#include "core/slam/slam_map.h"
#include "core/slam/state/existing_map.h"
#include "core/slam/state/variance_factor.h"
#include "core/slam/submaps/finished_submap.h"
#include "core/slam/submaps/submap.h"

namespace enfilade::slam {

// How well the last scans matched.
struct TrackQuality {
  int poor = 0;           // scans since the last good match
  int contradicting = 0;  // of these, scans that saw something else than the map shows

  friend bool operator==(const TrackQuality&, const TrackQuality&) = default;
};

// Where the robot is, relative to the active submap, at the last used scan.
struct Track {
  Pose2 T_submap_robot;
  std::optional<Pose2> T_odom_robot;
  TimeNs time = 0;
  TimeNs matched_at = 0;               // time of the last scan that matched well
  std::optional<Step> last_step;       // from the scan before to this one
  double length_since_keyframe = 0.0;  // m
  TrackQuality quality;
};

// All that a mapper knows.
struct MapperState {
  std::optional<ExistingMapEntry> entry;  // set if mapping continues an existing map, which is then submap 0
  std::optional<Submap> active;
  std::optional<Track> track;
  std::map<std::int64_t, FinishedSubmap> finished;
  std::map<std::int64_t, SlamNode> nodes;
  std::map<std::int64_t, LoopClosure> loop_closures;
  // Which submaps accepted loop closures join, in both directions. Derived from `loop_closures`.
  std::map<std::int64_t, std::set<std::int64_t>> joined;
  ErrorStatistics errors;
  bool ended = false;  // Finish was called
  // The number of keyframes when the graph was last solved, and what has come since.
  std::int64_t nodes_at_solve = 0;
  bool unsolved_closures = false;
  bool urgent_closures = false;  // some of them disagree with the estimate
  // The submap begun when the robot was lost, until a loop closure joins what followed to what was before.
  std::optional<std::int64_t> adrift_since;

  std::int64_t last_submap() const { return active ? active->id : static_cast<std::int64_t>(finished.size()) - 1; }
  bool is_existing_map(std::int64_t submap) const { return entry.has_value() && submap == 0; }
};

// Whether an accepted loop closure joins a keyframe of submap `since` or later to a submap before it, or vice versa.
bool IsRecognised(const MapperState& state, std::int64_t since);

// Adds one loop closure to `joined` if it is accepted; or rebuilds `joined` after some have changed.
void Join(const LoopClosure& closure, MapperState& state);
void JoinAll(MapperState& state);

// Bytes of memory held by all but the active submap. Grows with the distance driven.
std::size_t KeptBytes(const MapperState& state);

}  // namespace enfilade::slam
