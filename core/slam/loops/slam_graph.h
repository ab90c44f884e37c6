// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <set>

#include "core/slam/mapper/mapper_state.h"
#include "core/slam/slam_options.h"

namespace enfilade::slam {

// What solving changed in the state.
struct GraphChange {
  std::set<std::int64_t> nodes;
  std::set<std::int64_t> submaps;
  std::set<std::int64_t> closures;
  bool solved = false;
};

// Solves the pose graph of submaps and keyframes and puts the poses back. Edges: each submap to its own keyframes and
// to the next submap, as measured while mapping; and the closures that matched, submap to keyframe. First with a robust
// kernel on the closures; those whose chi2 is then small enough are valid and count fully, the others are switched off,
// and all is solved again (seed 001's two passes). Suspended closures take no part. The first keyframe is held, or the
// old map where mapping goes on in one: the edge from it to the first submap is what the entry says.
//
// A keyframe without closure has one edge only and follows its submap exactly: it is left out of the system and placed
// by composition, its covariance likewise.
GraphChange SolveSlamGraph(const GraphOptions& options, MapperState& state);

// chi2 of a closure by the present estimate.
double LoopClosureChi2(const MapperState& state, const LoopClosure& closure);

}  // namespace enfilade::slam
