// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/support/mapped_buildings.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "client/simulator/simulation.h"
#include "core/grid/overlay.h"
#include "core/slam/mapper/log_mapper.h"
#include "core/slam/mapper/mapper.h"
#include "tests/bench/support/recorded_scans.h"

namespace enfilade::bench {
namespace {

constexpr double kClearance = 0.3;   // m between a robot and walls
constexpr double kStep = 0.1;        // m of a drive
constexpr double kScanEvery = 0.3;   // m
constexpr double kRobotSpeed = 0.5;  // m/s, which decides where people are

// Whether a robot may stand there by its map: free, and no wall within the clearance.
bool IsClear(const Building& building, const Eigen::Vector2d& campus_point) {
  const Eigen::Vector2d p = Inverse(building.T_campus_map) * campus_point;
  return building.map->At(p) == localization::SearchableMap::Cell::kFree &&
         building.map->walls().At(p).squared_distance > kClearance * kClearance;
}

// A short motion that turns as it goes.
Pose2 Arc(double length, double turn) {
  return Pose2{0.0, 0.0, turn / 2.0} * Pose2{length, 0.0, 0.0} * Pose2{0.0, 0.0, turn / 2.0};
}

absl::StatusOr<std::shared_ptr<const localization::SearchableMap>> Searchable(const grid::OccupancyGrid& rendered) {
  const absl::StatusOr<grid::OccupancyGrid> grid = grid::ResampleToLattice(rendered, slam::SlamOptions().resolution);
  if (!grid.ok()) return grid.status();
  return std::make_shared<const localization::SearchableMap>(*grid, localization::LocalizationOptions());
}

// The scans of the `length` metres up to scan `last`.
std::vector<localization::QueryScan> ScansBefore(const std::vector<sensor::PairedScan>& scans, std::size_t last,
                                                 double length) {
  std::size_t first = last;
  for (double driven = 0.0; first > 0 && scans[first].T_odom_robot && scans[first - 1].T_odom_robot; --first) {
    driven += Between(*scans[first - 1].T_odom_robot, *scans[first].T_odom_robot).translation().norm();
    if (driven > length) break;
  }
  std::vector<localization::QueryScan> query;
  for (std::size_t i = first; i <= last; ++i) query.push_back({scans[i].scan, scans[i].T_odom_robot});
  return query;
}

}  // namespace

absl::StatusOr<Building> MapBuilding(simulator::Campus campus, std::uint64_t seed) {
  Building building;
  const simulator::Robot robot = campus.robots.front();
  building.level = robot.level;
  building.world = std::make_shared<const simulator::World>(std::move(campus));
  simulator::SimulationOptions options;
  options.seed = seed;
  absl::StatusOr<simulator::Drive> drive = simulator::SimulateDrive(building.world, robot.id, options);
  if (!drive.ok()) return drive.status();
  slam::LogMapper mapper({}, slam::SlamOptions{});
  std::int64_t sequence = 0;
  for (simulator::SimulatedRecord& record : drive->records) mapper.Add({++sequence, std::move(record.payload)});
  mapper.Finish();
  const auto map = Searchable(mapper.RenderGrid());
  if (!map.ok()) return map.status();
  building.map = *map;
  building.T_campus_map = drive->truth.poses.front().T_campus_robot;
  for (const simulator::TruePose& pose : drive->truth.poses) building.entered.insert(pose.area);
  return building;
}

std::optional<Pose2> FindPlace(const Building& building, bool known, Noise& noise) {
  const simulator::Campus& campus = building.world->campus();
  for (int attempt = 0; attempt < 2000; ++attempt) {
    const auto& area = campus.areas[static_cast<std::size_t>(noise.Below(static_cast<int>(campus.areas.size())))];
    Eigen::Vector2d low = area.outline.front();
    Eigen::Vector2d high = low;
    for (const Eigen::Vector2d& corner : area.outline) {
      low = low.cwiseMin(corner);
      high = high.cwiseMax(corner);
    }
    const Eigen::Vector2d at(noise.Uniform(low.x(), high.x()), noise.Uniform(low.y(), high.y()));
    const double yaw = noise.Uniform(-M_PI, M_PI);
    if (area.level != building.level || !simulator::Contains(area.outline, at)) continue;
    if ((building.entered.count(area.id) > 0) != known || (known && !IsClear(building, at))) continue;
    const bool in_box = std::any_of(campus.boxes.begin(), campus.boxes.end(),
                                    [&](const simulator::Box& box) { return simulator::Contains(box.outline, at); });
    if (!in_box) return Pose2{at.x(), at.y(), yaw};
  }
  return std::nullopt;
}

std::vector<Pose2> PlanDrive(const Building& building, const Pose2& start, double length, Noise& noise) {
  std::vector<Pose2> drive = {start};
  const double bend = noise.Uniform(-0.05, 0.05);  // rad per step
  for (double driven = 0.0; driven < length;) {
    const Pose2& last = drive.back();
    std::optional<double> turn;
    for (int i = 0; i < 32 && !turn; ++i) {
      const double by = bend + (i % 2 == 0 ? 1 : -1) * ((i + 1) / 2) * 0.2;
      bool clear = true;
      for (double ahead = kStep; ahead < 0.55; ahead += kStep) {
        clear = clear && IsClear(building, last * Pose2{0.0, 0.0, by} * Eigen::Vector2d(ahead, 0.0));
      }
      if (clear) turn = by;
    }
    if (!turn) break;
    if (std::abs(*turn) > 0.2) {  // on the spot, in steps
      const int steps = static_cast<int>(std::ceil(std::abs(*turn) / 0.2));
      for (int i = 0; i < steps; ++i) drive.push_back(drive.back() * Pose2{0.0, 0.0, *turn / steps});
    }
    drive.push_back(drive.back() * Arc(kStep, std::abs(*turn) > 0.2 ? 0.0 : *turn));
    driven += kStep;
  }
  return drive;
}

QueryDrive Record(const Building& building, const std::vector<Pose2>& drive, const simulator::ScannerOptions& scanner,
                  std::uint64_t seed) {
  const simulator::SimulationOptions defaults;
  Noise noise(seed);
  const double factors[2] = {1.0 + defaults.wheel_sigma * noise.Normal(), 1.0 + defaults.wheel_sigma * noise.Normal()};
  const double start = noise.Uniform(1000.0, 5000.0);  // s
  QueryDrive query;
  Pose2 T_odom_robot{noise.Uniform(-5.0, 5.0), noise.Uniform(-5.0, 5.0), noise.Uniform(-M_PI, M_PI)};
  Pose2 T_odom_scanned = T_odom_robot;
  for (std::size_t i = 0; i < drive.size(); ++i) {
    if (i > 0) {
      const Pose2 motion = Between(drive[i - 1], drive[i]);
      const double ahead = motion.translation().norm();
      double rolled[2];
      for (int wheel = 0; wheel < 2; ++wheel) {
        const double true_length = ahead + (wheel == 0 ? -0.5 : 0.5) * defaults.track * motion.yaw;
        rolled[wheel] =
            true_length * factors[wheel] + defaults.slip * std::sqrt(std::abs(true_length)) * noise.Normal();
      }
      T_odom_robot = T_odom_robot * Arc(0.5 * (rolled[0] + rolled[1]), (rolled[1] - rolled[0]) / defaults.track);
    }
    const Pose2 since = Between(T_odom_scanned, T_odom_robot);
    const bool due = since.translation().norm() >= kScanEvery || std::abs(since.yaw) >= kScanEvery;
    if (i != 0 && i + 1 != drive.size() && !due) continue;
    T_odom_scanned = T_odom_robot;
    const double seconds = start + kStep / kRobotSpeed * static_cast<double>(i);
    const simulator::Viewpoint view{*building.world, building.level, drive[i], seconds};
    sensor::LaserScan scan = simulator::ReadScan(view, scanner, Noise(Mix(seed, i)));
    scan.time = 1'700'000'000 * kNsPerSecond + static_cast<TimeNs>(seconds * 1e9);
    query.scans.push_back({std::move(scan), T_odom_robot});
    query.T_map_robot = Between(building.T_campus_map, drive[i]);
  }
  return query;
}

absl::StatusOr<MappedLog> MapLog(const std::string& path, int count, double length) {
  const absl::StatusOr<std::vector<sensor::PairedScan>> scans = ReadPairedScans(path, /*odometry=*/true);
  if (!scans.ok()) return scans.status();
  slam::Mapper mapper{slam::SlamOptions()};
  std::map<std::int64_t, std::size_t> others;  // by sequence: used, and no keyframes
  for (std::size_t i = 0; i < scans->size(); ++i) {
    const slam::ScanReport report = mapper.AddScan((*scans)[i]);
    if (report.used && !report.keyframe) others[(*scans)[i].sequence] = i;
  }
  mapper.Finish();
  slam::SlamMap slam_map;
  slam_map.Apply(mapper.TakeDelta());
  MappedLog log;
  const auto map = Searchable(mapper.RenderGrid());
  if (!map.ok()) return map.status();
  log.map = *map;
  const std::vector<slam::StampedPose> poses = slam::TrajectoryOf(slam_map);
  const std::size_t stride = std::max<std::size_t>(1, others.size() / static_cast<std::size_t>(std::max(count, 1)));
  std::size_t seen = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const auto found = others.find(slam_map.trajectory[i].sequence);
    if (found == others.end() || seen++ % stride != 0) continue;
    log.queries.push_back({ScansBefore(*scans, found->second, length), poses[i].T_map_robot});
  }
  return log;
}

}  // namespace enfilade::bench
