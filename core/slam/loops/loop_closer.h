// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/grid/scan_rays.h"
#include "core/slam/mapper/mapper_state.h"
#include "core/slam/slam_options.h"
#include "core/slam/submaps/submap_cache.h"

namespace enfilade::slam {

// Looks for `node` in the submaps where the candidate policy expects it. One row per attempt, accepted or rejected with
// the reason, ids from the state's next on. The state is not changed.
std::vector<LoopClosure> TryLoopClosures(const MapperState& state, const SlamNode& node, const grid::ScanRays& rays,
                                         const SlamOptions& options, SubmapCache& cache);

}  // namespace enfilade::slam
