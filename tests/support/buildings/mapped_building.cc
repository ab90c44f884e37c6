// SPDX-License-Identifier: Apache-2.0
#include "tests/support/buildings/mapped_building.h"

#include <memory>
#include <utility>
#include <variant>

#include "client/simulator/campus/random_building.h"
#include "client/simulator/simulation.h"
#include "core/base/noise.h"
#include "core/grid/log_odds_grid.h"
#include "core/grid/scan_rays.h"
#include "core/slam/mapper/log_mapper.h"
#include "tests/support/status_assertions.h"

namespace enfilade::testing {
namespace {

simulator::Drive DriveThrough(const simulator::Campus& campus, const DrivePart& part, double scan_hz) {
  simulator::SimulationOptions options;
  options.seed = part.seed;
  options.scan_hz = scan_hz;
  options.scanner.range_max = 12.0;
  options.laps = 1;
  auto drive = simulator::SimulateDrive(std::make_shared<const simulator::World>(campus), part.robot, options);
  EXPECT_OK(drive);
  return *std::move(drive);
}

// Whether the time lies in the part.
bool IsIn(const DrivePart& part, const simulator::GroundTruth& truth, TimeNs time) {
  const TimeNs first = truth.poses.front().time;
  const auto length = static_cast<double>(truth.poses.back().time - first);
  const double share = static_cast<double>(time - first) / length;
  return share >= part.begin && share <= part.end;
}

grid::OccupancyGrid DrawAtTruePoses(const simulator::Drive& drive, const DrivePart& part, const Pose2& T_campus_map) {
  grid::LogOddsGrid drawn(0.05, {});
  std::size_t number = 0;
  for (const simulator::SimulatedRecord& record : drive.records) {
    const auto* scan = std::get_if<sensor::LaserScan>(&record.payload);
    if (scan == nullptr) continue;
    const simulator::TruePose& truth = drive.truth.poses[number++];
    if (!IsIn(part, drive.truth, truth.time)) continue;
    EXPECT_OK(drawn.Insert(grid::RaysOf(*scan, Between(T_campus_map, truth.T_campus_robot), {})));
  }
  return drawn.ToOccupancyGrid();
}

MapOfPart MapBySlam(const simulator::Drive& drive, const DrivePart& part) {
  slam::LogMapper mapper({}, {});
  MapOfPart map;
  std::size_t number = 0;
  std::int64_t sequence = 0;
  for (const simulator::SimulatedRecord& simulated : drive.records) {
    const bool is_scan = std::holds_alternative<sensor::LaserScan>(simulated.payload);
    if (is_scan) ++number;
    const simulator::TruePose& truth = drive.truth.poses[number > 0 ? number - 1 : 0];
    if (!IsIn(part, drive.truth, truth.time) || (sequence == 0 && !is_scan)) continue;
    if (sequence == 0) map.T_campus_map = truth.T_campus_robot;
    mapper.Add({++sequence, simulated.payload});
  }
  mapper.Finish();
  map.grid = mapper.RenderGrid();
  return map;
}

}  // namespace

MapOfPart MapDrive(const simulator::Campus& campus, const DrivePart& part, Mapping mapping, const Pose2& T_campus_map) {
  if (mapping == Mapping::kSlam) return MapBySlam(DriveThrough(campus, part, 5.0), part);
  return {DrawAtTruePoses(DriveThrough(campus, part, 2.0), part, T_campus_map), T_campus_map};
}

MapPair TwoMapsOfABuilding(std::uint64_t seed, Mapping mapping) {
  simulator::BuildingOptions options;
  options.passages = 8;
  const simulator::Campus campus = simulator::RandomBuilding(seed, options);
  Noise noise(seed);
  const auto frame = [&] {
    return Pose2{noise.Uniform(-20.0, 20.0), noise.Uniform(-20.0, 20.0), noise.Uniform(-M_PI, M_PI)};
  };
  MapOfPart a = MapDrive(campus, {"robot", 0.0, 0.65, 2 * seed}, mapping, frame());
  MapOfPart b = MapDrive(campus, {"robot", 0.35, 1.0, 2 * seed + 1}, mapping, frame());
  return {std::move(a.grid), std::move(b.grid), Between(a.T_campus_map, b.T_campus_map)};
}

}  // namespace enfilade::testing
