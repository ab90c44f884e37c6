// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "core/slam/slam_options.h"
#include "core/slam/state/mapper_state.h"

namespace enfilade::slam {

// For each submap, by its id: the length (m) of the shortest path to it from submap `from` through the graph of
// submaps. The step to the next submap costs the distance driven in the submap, an accepted loop closure nothing. The
// possible drift between two submaps grows with this length (Dijkstra projection: Bosse et al. 2004, Olson 2009).
std::vector<double> DriftLengths(const MapperState& state, std::int64_t from);

// A submap in which a node may be found, and the window to search.
struct LoopCandidate {
  std::int64_t submap = 0;
  double distance = 0.0;    // m, from the node to the submap's nearest keyframe, by the current estimate
  double half_width = 0.0;  // m
  double half_angle = 0.0;  // rad
  bool is_entry = false;    // an existing map in which the robot has not been found yet
  // The hits were seen from the node, or from near it: no wall that the submap shows only from the other side is
  // theirs.
  bool seen_from_node = true;
};

// The finished submaps to try for `node`, nearest first. Excluded are the most recent submaps (`min_submap_gap`),
// submaps tried from a recent node, and submaps too far away given the possible drift. Empty soon after an attempt or a
// closure. An existing map is a candidate from the first keyframe on. Until the robot has been found in it, its window
// is widened by three standard deviations of the entry.
std::vector<LoopCandidate> SelectLoopCandidates(const MapperState& state, const SlamNode& node,
                                                const LoopOptions& options);

}  // namespace enfilade::slam
