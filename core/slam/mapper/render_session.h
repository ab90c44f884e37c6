// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "core/geometry/pose2.h"
#include "core/grid/occupancy_grid.h"
#include "core/slam/slam_map.h"
#include "core/slam/slam_options.h"

namespace enfilade::slam {

// What a session's scans have shown, drawn from its stored submaps in another frame; with the identity the same grid,
// bit for bit, as Mapper::RenderGrid after Finish. `continues_map`: the session continued an existing map, which is its
// submap 0 and is left out. Submaps that are not finished are left out, too. Empty if there are none. DATA_LOSS if a
// submap is damaged.
absl::StatusOr<grid::OccupancyGrid> RenderSession(const SlamMap& session, bool continues_map, const Pose2& T_to_map,
                                                  const SlamOptions& options);

}  // namespace enfilade::slam
