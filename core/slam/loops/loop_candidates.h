// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "core/slam/mapper/mapper_state.h"
#include "core/slam/slam_options.h"

namespace enfilade::slam {

// How far, in metres of drift-laden driving, each submap (by its id) is from `from` along the shortest way through the
// graph: a submap's own way to the next, nothing across an accepted closure. What drift there can be between two
// submaps grows with this (Dijkstra projection: Bosse et al. 2004, Olson 2009).
std::vector<double> DriftLengths(const MapperState& state, std::int64_t from);

// A submap in which a node may be seen, and how unsure its place there is.
struct LoopCandidate {
  std::int64_t submap = 0;
  double distance = 0.0;    // m, from the node to the submap's nearest keyframe, by the present estimate
  double half_width = 0.0;  // m, of the search
  double half_angle = 0.0;  // rad
  bool is_entry = false;    // an old map in which the robot has not been found yet
};

// Which finished submaps to try for `node`, the most likely first: not the node's own or the one before it, not tried
// from a recent node, and near enough under the drift there may have been. None so soon after an
// attempt or a closure. An old map that mapping goes on in is one of them from the first keyframe on, in a search as
// wide as its entry is unsure until the robot has been found in it.
std::vector<LoopCandidate> SelectLoopCandidates(const MapperState& state, const SlamNode& node,
                                                const LoopOptions& options);

}  // namespace enfilade::slam
