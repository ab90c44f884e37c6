// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "core/slam/matching/local_matching.h"
#include "core/slam/slam_options.h"
#include "core/slam/state/mapper_state.h"
#include "core/slam/submaps/submap.h"

namespace enfilade::slam {

// Whether a scan at this distance from the last keyframe becomes a keyframe.
bool IsKeyframeDue(const Pose2& T_last_now, const KeyframeOptions& options);

// Whether the next keyframe, at `T_submap_robot`, starts a new submap: enough keyframes, or too far from the origin.
bool IsSubmapFull(const Submap& submap, const Pose2& T_submap_robot, const SubmapOptions& options);

// The quality after one more scan, matched with the result `match`.
TrackQuality Updated(const TrackQuality& quality, const LocalMatch& match, const LocalMatchOptions& options);

bool IsLost(const TrackQuality& quality, const QualityOptions& options);

// Whether to give up on the active submap because the scans contradict it: the robot was carried away, or slipped
// beyond the search window. Scans that merely show too little to match do not count.
bool IsElsewhere(const TrackQuality& quality, const QualityOptions& options);

// Whether to solve the pose graph, now of `nodes` keyframes, last solved with `nodes_at_solve`. See
// GraphOptions::growth.
bool IsSolveDue(std::int64_t nodes, std::int64_t nodes_at_solve, bool urgent, const GraphOptions& options);

// Whether a scan may be inserted into the submap: it fits, or it does not contradict the submap.
bool MayInsert(const LocalMatch& match, const LocalMatchOptions& options);

}  // namespace enfilade::slam
