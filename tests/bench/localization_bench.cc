// SPDX-License-Identifier: Apache-2.0
// Global localisation in simulated buildings, as JSON on standard output:
//   bench_localization [--buildings N] [--first-seed S] [--places N] [--campus NAME] [--fov DEG] [--drive M] [--list]
// Each building is driven through once and mapped as one map. Then a robot is put at fresh places, with other noise and
// people elsewhere, and located by one scan, and again by the scans of a short drive. "known": places in areas that the
// mapping robot entered, on ground that its map has as free. "unknown": places in areas that it never entered; there,
// few certain answers can be right (the place may be seen through a
// door); a fifth as many. Right: within 0.5 m and 10 degrees.

#include <CLI/CLI.hpp>
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <ctime>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "client/simulator/campus/random_building.h"
#include "client/simulator/campus/shipped_campuses.h"
#include "client/simulator/sensors/noise.h"
#include "client/simulator/simulation.h"
#include "core/grid/overlay.h"
#include "core/localization/localize.h"
#include "core/slam/mapper/log_mapper.h"
#include "fmt/format.h"

namespace enfilade::bench {
namespace {

constexpr double kRightDistance = 0.5;  // m
constexpr double kClearance = 0.3;      // m between a robot and walls
constexpr double kStep = 0.1;           // m of a drive
constexpr double kScanEvery = 0.3;      // m
constexpr double kRobotSpeed = 0.5;     // m/s, which decides where people are

struct Tally {
  int places = 0;
  int right = 0;
  int wrong = 0;
  int none = 0;
  int confident_right = 0;
  int confident_wrong = 0;
  double seconds = 0.0;  // of the processor
  double slowest = 0.0;
  std::vector<double> errors;        // m, of the right ones
  std::vector<double> nees;          // of the right ones: normalised squared error, 3 degrees of freedom
  std::vector<double> right_behind;  // log-odds by which the right pose is behind, where it is not the first
};

struct Building {
  std::shared_ptr<const simulator::World> world;
  std::string level;
  std::shared_ptr<const localization::SearchableMap> map;
  Pose2 T_campus_map;
  std::set<std::string> entered;
};

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
  const absl::StatusOr<grid::OccupancyGrid> grid =
      grid::ResampleToLattice(mapper.RenderGrid(), slam::SlamOptions().resolution);
  if (!grid.ok()) return grid.status();
  building.map = std::make_shared<localization::SearchableMap>(*grid, localization::LocalizationOptions());
  building.T_campus_map = drive->truth.poses.front().T_campus_robot;
  for (const simulator::TruePose& pose : drive->truth.poses) building.entered.insert(pose.area);
  return building;
}

// Whether a robot may stand there by its map: free, and no wall within the clearance.
bool IsClear(const Building& building, const Eigen::Vector2d& campus_point) {
  const Eigen::Vector2d p = Inverse(building.T_campus_map) * campus_point;
  return building.map->At(p) == localization::SearchableMap::Cell::kFree &&
         building.map->walls().At(p).squared_distance > kClearance * kClearance;
}

std::optional<Pose2> FindPlace(const Building& building, bool known, simulator::Noise& noise) {
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

// A short motion that turns as it goes.
Pose2 Arc(double length, double turn) {
  return Pose2{0.0, 0.0, turn / 2.0} * Pose2{length, 0.0, 0.0} * Pose2{0.0, 0.0, turn / 2.0};
}

// A drive of about `length` over clear ground: straight on, or with the smallest turn after which the way is free.
std::vector<Pose2> PlanDrive(const Building& building, const Pose2& start, double length, simulator::Noise& noise) {
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

struct QueryDrive {
  std::vector<localization::QueryScan> scans;
  Pose2 T_campus_robot;  // at the last scan
};

// What the robot records on the way: scans, and odometry whose wheels' sizes are wrong and which slip.
QueryDrive Record(const Building& building, const std::vector<Pose2>& drive, const simulator::ScannerOptions& scanner,
                  std::uint64_t seed) {
  const simulator::SimulationOptions defaults;
  simulator::Noise noise(seed);
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
    sensor::LaserScan scan = simulator::ReadScan(view, scanner, simulator::Noise(simulator::Mix(seed, i)));
    scan.time = 1'700'000'000 * kNsPerSecond + static_cast<TimeNs>(seconds * 1e9);
    query.scans.push_back({std::move(scan), T_odom_robot});
    query.T_campus_robot = drive[i];
  }
  return query;
}

bool IsRight(const Pose2& a, const Pose2& b) {
  const Pose2 off = Between(a, b);
  return off.translation().norm() <= kRightDistance && std::abs(off.yaw) <= 10.0 * kDegree;
}

absl::Status Score(const Building& building, const QueryDrive& query, const std::string& label, bool list,
                   Tally& tally) {
  const std::clock_t begin = std::clock();
  const absl::StatusOr<localization::Localization> found =
      localization::Localize(query.scans, {{[&] { return building.map; }}}, localization::LocalizationOptions(),
                             [] { return absl::OkStatus(); });
  const double seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  ++tally.places;
  tally.seconds += seconds;
  tally.slowest = std::max(tally.slowest, seconds);
  if (!found.ok() && !absl::IsInvalidArgument(found.status())) return found.status();
  if (!found.ok() || found->poses.empty()) {
    ++tally.none;
    if (list) std::cerr << label << " none: " << (found.ok() ? found->reason : found.status().ToString()) << '\n';
    return absl::OkStatus();
  }
  const localization::LocatedPose& first = found->poses.front();
  const Pose2 truth = Between(building.T_campus_map, query.T_campus_robot);
  const Pose2 off = Between(truth, first.T_map_robot.pose);
  const bool right = IsRight(truth, first.T_map_robot.pose);
  (right ? tally.right : tally.wrong) += 1;
  if (first.confident) (right ? tally.confident_right : tally.confident_wrong) += 1;
  if (right) {
    tally.errors.push_back(off.translation().norm());
    const Eigen::Vector3d e(first.T_map_robot.pose.x - truth.x, first.T_map_robot.pose.y - truth.y,
                            WrapAngle(first.T_map_robot.pose.yaw - truth.yaw));
    tally.nees.push_back(e.dot(first.T_map_robot.covariance.ldlt().solve(e)));
  } else {
    for (const localization::LocatedPose& one : found->poses) {
      if (!IsRight(truth, one.T_map_robot.pose)) continue;
      tally.right_behind.push_back(one.odds_behind);
      break;
    }
  }
  if (list && (!right || !first.confident)) {
    std::string behind = "-";
    for (const localization::LocatedPose& one : found->poses) {
      if (IsRight(truth, one.T_map_robot.pose)) {
        behind = fmt::format("{:.1f}", one.odds_behind);
        break;
      }
    }
    std::cerr << fmt::format("{} {}{} off {:.2f} m {:.2f} rad, truth ({:.2f} {:.2f} {:.2f}) {} behind: {} poses, {}\n",
                             label, first.confident ? "CONFIDENT " : "", right ? "right" : "WRONG",
                             off.translation().norm(), off.yaw, truth.x, truth.y, truth.yaw, behind,
                             found->poses.size(), found->reason);
  }
  return absl::OkStatus();
}

double Quantile(std::vector<double> values, double q) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1))];
}

nlohmann::json ToJson(const Tally& tally) {
  const auto share = [&](int count) { return tally.places > 0 ? static_cast<double>(count) / tally.places : 0.0; };
  return {{"places", tally.places},
          {"right_at_rank_1", share(tally.right)},
          {"wrong_at_rank_1", share(tally.wrong)},
          {"nowhere_known", share(tally.none)},
          {"confident", share(tally.confident_right + tally.confident_wrong)},
          {"confident_and_wrong", tally.confident_wrong},
          {"right_listed_below_rank_1", tally.right_behind.size()},
          {"median_error_m", Quantile(tally.errors, 0.5)},
          {"error_95_m", Quantile(tally.errors, 0.95)},
          {"median_nees", Quantile(tally.nees, 0.5)},
          {"nees_95", Quantile(tally.nees, 0.95)},
          {"seconds_per_query", tally.places > 0 ? tally.seconds / tally.places : 0.0},
          {"slowest_query_s", tally.slowest}};
}

struct Bench {
  int places = 100;
  double drive = 3.0;
  bool list = false;
  simulator::ScannerOptions scanner;
  Tally one_scan;
  Tally driven;
  Tally unknown_one_scan;

  absl::Status Run(const std::string& name, const Building& building, std::uint64_t seed) {
    for (const bool known : {true, false}) {
      simulator::Noise noise(simulator::Mix(seed, known ? 1 : 2));
      for (int i = 0; i < (known ? places : (places + 4) / 5); ++i) {
        const std::optional<Pose2> place = FindPlace(building, known, noise);
        if (!place) break;  // every area was entered
        const std::uint64_t own = simulator::Mix(seed, known ? 3 : 4, static_cast<std::uint64_t>(i));
        const std::string label = fmt::format("{} {} {}", name, known ? "known" : "unknown", i);
        const QueryDrive standing = Record(building, {*place}, scanner, own);
        if (absl::Status s = Score(building, standing, label + " scan", list, known ? one_scan : unknown_one_scan);
            !s.ok()) {
          return s;
        }
        if (drive <= 0.0 || !known) continue;
        const QueryDrive driving = Record(building, PlanDrive(building, *place, drive, noise), scanner, own);
        if (absl::Status s = Score(building, driving, label + " drive", list, driven); !s.ok()) return s;
      }
    }
    return absl::OkStatus();
  }
};

absl::StatusOr<simulator::Campus> CampusOf(const std::string& name, std::uint64_t seed) {
  if (name.empty()) return simulator::RandomBuilding(seed);
  return simulator::ShippedCampus(name);
}

}  // namespace
}  // namespace enfilade::bench

int main(int argc, char** argv) {
  using namespace enfilade;
  using namespace enfilade::bench;
  CLI::App app("Global localisation in simulated buildings");
  int buildings = 50;
  std::uint64_t first_seed = 7601;
  std::string campus;
  double fov = 360.0;
  Bench bench;
  app.add_option("--buildings", buildings)->capture_default_str();
  app.add_option("--first-seed", first_seed)->capture_default_str();
  app.add_option("--places", bench.places, "In each building")->capture_default_str();
  app.add_option("--campus", campus, "A shipped campus instead of random buildings");
  app.add_option("--fov", fov, "Field of view of the scanner, deg")->capture_default_str();
  app.add_option("--drive", bench.drive, "m; 0: one scan only")->capture_default_str();
  app.add_flag("--list", bench.list, "Each place that is not certain, on standard error");
  CLI11_PARSE(app, argc, argv);
  bench.scanner.field_of_view = fov * kDegree;
  bench.scanner.beams = std::max(2, static_cast<int>(std::lround(2.0 * fov)));
  double mapping = 0.0;
  for (int i = 0; i < buildings; ++i) {
    const std::uint64_t seed = first_seed + static_cast<std::uint64_t>(i);
    const std::clock_t begin = std::clock();
    absl::StatusOr<simulator::Campus> one = CampusOf(campus, seed);
    absl::StatusOr<Building> building = one.ok() ? MapBuilding(*std::move(one), seed) : one.status();
    mapping += static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    const absl::Status status = building.ok() ? bench.Run(fmt::format("{}", seed), *building, seed) : building.status();
    if (!status.ok()) {
      std::cerr << "bench_localization: " << seed << ": " << status.message() << '\n';
      return 1;
    }
  }
  const nlohmann::json report = {{"campus", campus.empty() ? "random" : campus},
                                 {"buildings", buildings},
                                 {"first_seed", first_seed},
                                 {"field_of_view_deg", fov},
                                 {"mapping_s_per_building", buildings > 0 ? mapping / buildings : 0.0},
                                 {"known", {{"one_scan", ToJson(bench.one_scan)}, {"drive", ToJson(bench.driven)}}},
                                 {"unknown", {{"one_scan", ToJson(bench.unknown_one_scan)}}}};
  std::cout << report.dump(2) << '\n';
  return 0;
}
