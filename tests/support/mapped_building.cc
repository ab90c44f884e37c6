// SPDX-License-Identifier: Apache-2.0
#include "tests/support/mapped_building.h"

#include <memory>
#include <variant>

#include "client/simulator/campus/random_building.h"
#include "client/simulator/sensors/noise.h"
#include "client/simulator/simulation.h"
#include "core/grid/log_odds_grid.h"
#include "core/grid/scan_rays.h"
#include "tests/support/status_assertions.h"

namespace enfilade::testing {

grid::OccupancyGrid MapOfDrive(const simulator::Campus& campus, const DrivePart& part, const Pose2& T_campus_map) {
  simulator::SimulationOptions options;
  options.seed = part.seed;
  options.scan_hz = 2.0;
  options.scanner.range_max = 12.0;
  options.laps = 1;
  const auto drive = simulator::SimulateDrive(std::make_shared<const simulator::World>(campus), part.robot, options);
  EXPECT_OK(drive);
  grid::LogOddsGrid drawn(0.05, {});
  const double scans = static_cast<double>(drive->truth.poses.size());
  std::size_t number = 0;
  for (const simulator::SimulatedRecord& record : drive->records) {
    const auto* scan = std::get_if<sensor::LaserScan>(&record.payload);
    if (scan == nullptr) continue;
    const double share = static_cast<double>(number) / scans;
    const Pose2 T_map_robot = Between(T_campus_map, drive->truth.poses[number].T_campus_robot);
    ++number;
    if (share < part.begin || share > part.end) continue;
    EXPECT_OK(drawn.Insert(grid::RaysOf(*scan, T_map_robot, {})));
  }
  return drawn.ToOccupancyGrid();
}

MapPair TwoMapsOfABuilding(std::uint64_t seed) {
  simulator::BuildingOptions options;
  options.passages = 8;
  const simulator::Campus campus = simulator::RandomBuilding(seed, options);
  simulator::Noise noise(seed);
  const auto frame = [&] {
    return Pose2{noise.Uniform(-20.0, 20.0), noise.Uniform(-20.0, 20.0), noise.Uniform(-M_PI, M_PI)};
  };
  const Pose2 T_campus_a = frame();
  const Pose2 T_campus_b = frame();
  return {MapOfDrive(campus, {"robot", 0.0, 0.65, 2 * seed}, T_campus_a),
          MapOfDrive(campus, {"robot", 0.35, 1.0, 2 * seed + 1}, T_campus_b), Between(T_campus_a, T_campus_b)};
}

}  // namespace enfilade::testing
