// SPDX-License-Identifier: Apache-2.0
// Global localisation in simulated buildings, as JSON on standard output:
//   bench_localization [--buildings N] [--first-seed S] [--places N] [--campus NAME | --log FILE] [--fov DEG]
//                      [--drive M] [--list]
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
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/simulator/campus/random_building.h"
#include "client/simulator/campus/shipped_campuses.h"
#include "client/simulator/sensors/sensors.h"
#include "core/base/noise.h"
#include "core/localization/localize.h"
#include "fmt/format.h"
#include "tests/bench/support/mapped_buildings.h"

namespace enfilade::bench {
namespace {

constexpr double kRightDistance = 0.5;  // m

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

bool IsRight(const Pose2& a, const Pose2& b) {
  const Pose2 off = Between(a, b);
  return off.translation().norm() <= kRightDistance && std::abs(off.yaw) <= 10.0 * kDegree;
}

using SharedMap = std::shared_ptr<const localization::SearchableMap>;

absl::Status Score(const SharedMap& map, const QueryDrive& query, const std::string& label, bool list, Tally& tally) {
  const std::clock_t begin = std::clock();
  const absl::StatusOr<localization::Localization> found = localization::Localize(
      query.scans, {{[&] { return map; }}}, localization::LocalizationOptions(), [] { return absl::OkStatus(); });
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
  const Pose2& truth = query.T_map_robot;
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

  absl::Status RunLog(const std::string& path) {
    for (const bool driving : {false, true}) {
      const absl::StatusOr<MappedLog> log = MapLog(path, places, driving ? drive : 0.0);
      if (!log.ok()) return log.status();
      for (std::size_t i = 0; i < log->queries.size(); ++i) {
        const std::string label = fmt::format("{} {} {}", path, driving ? "drive" : "scan", i);
        if (absl::Status s = Score(log->map, log->queries[i], label, list, driving ? driven : one_scan); !s.ok()) {
          return s;
        }
      }
    }
    return absl::OkStatus();
  }

  absl::Status Run(const std::string& name, const Building& building, std::uint64_t seed) {
    for (const bool known : {true, false}) {
      Noise noise(Mix(seed, known ? 1 : 2));
      for (int i = 0; i < (known ? places : (places + 4) / 5); ++i) {
        const std::optional<Pose2> place = FindPlace(building, known, noise);
        if (!place) break;  // every area was entered
        const std::uint64_t own = Mix(seed, known ? 3 : 4, static_cast<std::uint64_t>(i));
        const std::string label = fmt::format("{} {} {}", name, known ? "known" : "unknown", i);
        const QueryDrive standing = Record(building, {*place}, scanner, own);
        if (absl::Status s = Score(building.map, standing, label + " scan", list, known ? one_scan : unknown_one_scan);
            !s.ok()) {
          return s;
        }
        if (drive <= 0.0 || !known) continue;
        const QueryDrive driving = Record(building, PlanDrive(building, *place, drive, noise), scanner, own);
        if (absl::Status s = Score(building.map, driving, label + " drive", list, driven); !s.ok()) return s;
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
  std::string log;
  double fov = 360.0;
  Bench bench;
  app.add_option("--buildings", buildings)->capture_default_str();
  app.add_option("--first-seed", first_seed)->capture_default_str();
  app.add_option("--places", bench.places, "In each building")->capture_default_str();
  app.add_option("--campus", campus, "A shipped campus instead of random buildings");
  app.add_option("--log", log, "A recorded log instead: scans that are no keyframes, in the map of all keyframes");
  app.add_option("--fov", fov, "Field of view of the scanner, deg")->capture_default_str();
  app.add_option("--drive", bench.drive, "m; 0: one scan only")->capture_default_str();
  app.add_flag("--list", bench.list, "Each place that is not certain, on standard error");
  CLI11_PARSE(app, argc, argv);
  bench.scanner.field_of_view = fov * kDegree;
  bench.scanner.beams = std::max(2, static_cast<int>(std::lround(2.0 * fov)));
  const auto fail = [](const std::string& what, const absl::Status& status) {
    std::cerr << "bench_localization: " << what << ": " << status.message() << '\n';
    return 1;
  };
  if (!log.empty()) {
    if (const absl::Status status = bench.RunLog(log); !status.ok()) return fail(log, status);
    std::cout << nlohmann::json{{"one_scan", ToJson(bench.one_scan)}, {"drive", ToJson(bench.driven)}}.dump(2) << '\n';
    return 0;
  }
  double mapping = 0.0;
  for (int i = 0; i < buildings; ++i) {
    const std::uint64_t seed = first_seed + static_cast<std::uint64_t>(i);
    const std::clock_t begin = std::clock();
    absl::StatusOr<simulator::Campus> one = CampusOf(campus, seed);
    absl::StatusOr<Building> building = one.ok() ? MapBuilding(*std::move(one), seed) : one.status();
    mapping += static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    const absl::Status status = building.ok() ? bench.Run(fmt::format("{}", seed), *building, seed) : building.status();
    if (!status.ok()) return fail(fmt::format("{}", seed), status);
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
