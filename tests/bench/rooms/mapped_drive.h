// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/simulator/campus/campus.h"
#include "core/geometry/pose2.h"
#include "core/grid/occupancy_grid.h"
#include "core/rooms/room_partition.h"
#include "tests/support/rooms/room_scores.h"

namespace enfilade::bench {

// A simulated robot's drive as it is mapped by SLAM, and the truth.
struct MappedDrive {
  simulator::Campus campus;
  std::string level;
  grid::OccupancyGrid grid;
  Pose2 T_campus_map;  // where the drive began
  std::vector<testing::DrivePoint> drive;
  std::vector<testing::DrivePassage> passages;
  std::vector<rooms::PassageHint> reported;  // by the robot's door detector, wherever it takes itself through a door
};

struct MappedDriveOptions {
  std::uint64_t seed = 1;
  std::optional<int> laps = {};
  // Each way from a reported passage to the next is mapped as a session, and the sessions are joined, as surveys do it.
  bool sessions = false;
  // What is mapped is kept here, and read from here if it is; nothing is kept if it is empty.
  std::filesystem::path cache = {};
};

// "random:SEED", "suites:SEED", "halls:SEED" or a shipped campus; the campus's first robot.
absl::StatusOr<MappedDrive> MapDrive(const std::string& campus, const MappedDriveOptions& options);

}  // namespace enfilade::bench
