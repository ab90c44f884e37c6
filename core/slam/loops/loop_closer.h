// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/grid/scan_rays.h"
#include "core/slam/loops/loop_matching.h"
#include "core/slam/loops/submap_cache.h"
#include "core/slam/slam_options.h"
#include "core/slam/state/mapper_state.h"

namespace enfilade::slam {

// The row for an attempt to find `node` in `submap`, the next one after those of the state and `more` others.
LoopClosure ToLoopClosure(const MapperState& state, std::size_t more, std::int64_t submap, std::int64_t node,
                          LoopMatch match);

// Looks for `node` in the candidate submaps (SelectLoopCandidates). Returns one row per attempt, accepted or rejected,
// with the reason; ids continue those of the state. Does not change the state.
std::vector<LoopClosure> TryLoopClosures(const MapperState& state, const SlamNode& node, const grid::ScanRays& rays,
                                         const SlamOptions& options, SubmapCache& cache);

}  // namespace enfilade::slam
