// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "core/slam/matching/local_matching.h"
#include "core/slam/slam_options.h"
#include "core/slam/submaps/submap.h"

namespace enfilade::slam {

// Whether a scan this far from the last keyframe becomes one.
bool IsKeyframeDue(const Pose2& T_last_now, const KeyframeOptions& options);

// Whether the next keyframe, at `T_submap_robot`, belongs into a new submap: enough keyframes, or out of bounds.
bool IsSubmapFull(const Submap& submap, const Pose2& T_submap_robot, const SubmapOptions& options);

// How well the robot has known its place lately.
struct TrackQuality {
  int poor = 0;           // scans since the last good match
  int contradicting = 0;  // of them, those that saw something else than the map shows

  friend bool operator==(const TrackQuality&, const TrackQuality&) = default;
};

// After a scan that matched so.
TrackQuality Updated(const TrackQuality& quality, const LocalMatch& match, const LocalMatchOptions& options);

bool IsLost(const TrackQuality& quality, const QualityOptions& options);

// Whether to give up on the active submap: what the scans show is not there (the robot was carried off, or slipped
// beyond what the search covers). A scan that shows too little to match is no reason.
bool IsElsewhere(const TrackQuality& quality, const QualityOptions& options);

// Whether the pose graph of `nodes` keyframes is to be solved, last solved with `nodes_at_solve`.
bool IsSolveDue(std::int64_t nodes, std::int64_t nodes_at_solve, bool urgent, const GraphOptions& options);

// Whether a scan may be drawn into the submap: it fits, or it does not contradict what is there.
bool MayInsert(const LocalMatch& match, const LocalMatchOptions& options);

}  // namespace enfilade::slam
