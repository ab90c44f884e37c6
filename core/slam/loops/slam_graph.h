// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <set>
#include <vector>

#include "absl/status/statusor.h"
#include "core/slam/slam_options.h"
#include "core/slam/state/mapper_state.h"

namespace enfilade::slam {

// The ids of what a solution changed in the state.
struct GraphChange {
  std::set<std::int64_t> nodes;
  std::set<std::int64_t> submaps;
  std::set<std::int64_t> loop_closures;
};

// Solves the pose graph of submaps and keyframes and updates their poses and covariances. Edges: from each submap to
// its own keyframes and to the next submap, as measured while mapping; and loop closures, from submap to keyframe. Two
// passes: the first with a robust kernel (Cauchy) on the loop closures; closures with a chi2 below `max_chi2` are then
// accepted and count fully, the others are rejected and left out of the second. Suspended closures take no part. Held
// is the first keyframe; or the existing map, tied to the first own submap by an edge that the entry gives.
//
// Covariances are multiplied by the variance factor (variance_factor.h), which the solution updates.
//
// A keyframe without closure has a single edge and follows its submap exactly: it is left out of the system, and its
// pose and covariance are composed.
GraphChange SolveSlamGraph(const GraphOptions& options, MapperState& state);

// Solves the graph with the loop closures `trusted` counting fully, whatever their state, and Cauchy's kernel on the
// ties between submaps and on the other accepted closures, so that the ties give way that fit least. Updates the poses
// of submaps and of keyframes with closures. Returns the measured ties with a chi2 above `max_chi2`, by the id of their
// first submap, with information by which they would have the expected chi2 of 3. Empty if it cannot be solved.
std::map<std::int64_t, Eigen::Matrix3d> LoosenTies(const GraphOptions& options, const std::set<std::int64_t>& trusted,
                                                   MapperState& state);

// How well the graph knows where keyframes are relative to keyframe `from`: for each of `to` the covariance of
// T_from_to in (x, y, yaw), in the frame of `from`; zero for `from` itself. The poses must be solved. INVALID_ARGUMENT:
// no such keyframe. FAILED_PRECONDITION: the graph does not determine them.
absl::StatusOr<std::vector<Eigen::Matrix3d>> RelativeCovariances(const MapperState& state, std::int64_t from,
                                                                 const std::vector<std::int64_t>& to);

// Whether the tie from submap `id` to the next one was measured, so that its covariance is to be multiplied by the
// variance factor; otherwise the covariance is stated: that of the entry into an existing map, or of a lost robot.
bool IsMeasured(const MapperState& state, std::int64_t id, const NextSubmap& next);

// chi2 of a loop closure at the current estimate.
double LoopClosureChi2(const MapperState& state, const LoopClosure& closure);

}  // namespace enfilade::slam
