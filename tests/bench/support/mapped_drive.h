// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/simulator/campus/campus.h"
#include "core/geometry/pose2.h"
#include "core/grid/occupancy_grid.h"
#include "tests/support/room_scores.h"

namespace enfilade::bench {

// A simulated robot's drive as it is mapped by SLAM, and the truth.
struct MappedDrive {
  simulator::Campus campus;
  std::string level;
  grid::OccupancyGrid grid;
  Pose2 T_campus_map;  // where the drive began
  std::vector<testing::DrivePoint> drive;
  std::vector<testing::DrivePassage> passages;
};

// "random:SEED" or a shipped campus; the campus's first robot. The grid and the trajectory are kept in `cache` and read
// from there if they are (nothing is kept if it is empty).
absl::StatusOr<MappedDrive> MapDrive(const std::string& campus, std::uint64_t seed, const std::filesystem::path& cache);

}  // namespace enfilade::bench
