// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "absl/status/status.h"
#include "core/grid/occupancy_grid.h"
#include "core/slam/slam_map.h"

namespace enfilade::cli {

// Where the robot was at each scan: lines `t x y yaw` (absolute seconds with nine decimals, m, rad).
std::string TrajectoryText(const slam::SlamMap& map);

// Writes the result of SLAM into `directory`, which is created if missing: trajectory.txt (TrajectoryText), map.pgm
// with map.yaml, map.png, closures.json, and with `plot` plot.png. A map without a known cell has no image: then only
// trajectory.txt and closures.json are written.
absl::Status WriteSlamFiles(const std::filesystem::path& directory, const slam::SlamMap& map,
                            const grid::OccupancyGrid& grid, bool plot);

}  // namespace enfilade::cli
