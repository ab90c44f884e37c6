// SPDX-License-Identifier: Apache-2.0
// Door detection in random simulated buildings, and on a recording with known doors, as JSON on standard output:
//   bench_doors [--buildings N] [--first-seed S] [--presets a,b] [--intel LOG DOORS] [--list]
//               [--kind random|suites|halls] [--scan-hz HZ] [--beams N] [--fov DEG]
// A reported passage is right if the robot really passed a door at most 3 s later or 15 s earlier and at most 2.5 m
// from the reported place, and no other reported passage is closer to that one. On the recording: if it is within 6 s
// of a trusted passage.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <ctime>
#include <fstream>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/simulator/simulation.h"
#include "client/simulator/simulation_files.h"
#include "core/doors/door_detector.h"
#include "core/sensor/scan_pairing.h"
#include "fmt/format.h"
#include "tests/bench/support/recorded_scans.h"

namespace enfilade::bench {
namespace {

struct Tally {
  std::int64_t passages = 0;
  std::int64_t found = 0;
  std::int64_t false_alarms = 0;
  std::int64_t latched = 0;
  std::int64_t candidates = 0;
  double travelled = 0.0;  // m
  double seconds = 0.0;    // of the detector
  std::int64_t scans = 0;
  std::vector<double> errors;  // m, of the door's place
};

struct Scenario {
  std::vector<sensor::PairedScan> scans;
  simulator::GroundTruth truth;
};

absl::StatusOr<Scenario> Drive(const std::string& kind, std::uint64_t seed, simulator::SimulationOptions options) {
  options.seed = seed;
  absl::StatusOr<simulator::Campus> campus = simulator::LoadCampus(fmt::format("{}:{}", kind, seed));
  if (!campus.ok()) return campus.status();
  const std::string robot = campus->robots.front().id;
  const auto world = std::make_shared<const simulator::World>(*std::move(campus));
  absl::StatusOr<simulator::Drive> drive = simulator::SimulateDrive(world, robot, options);
  if (!drive.ok()) return drive.status();
  Scenario scenario;
  scenario.truth = std::move(drive->truth);
  Pose2 T_odom_robot;
  for (simulator::SimulatedRecord& record : drive->records) {
    if (const auto* odometry = std::get_if<sensor::Odometry>(&record.payload)) T_odom_robot = odometry->T_odom_robot;
    if (auto* scan = std::get_if<sensor::LaserScan>(&record.payload)) {
      scenario.scans.push_back({0, std::move(*scan), T_odom_robot});
    }
  }
  return scenario;
}

std::vector<doors::DoorEvent> Detect(const std::vector<sensor::PairedScan>& scans, const doors::DoorOptions& options,
                                     Tally& tally) {
  const std::clock_t begin = std::clock();
  doors::DoorDetector detector(options);
  std::vector<doors::DoorEvent> all;
  for (const sensor::PairedScan& scan : scans) {
    if (!scan.T_odom_robot) continue;
    for (doors::DoorEvent& event : detector.Add(scan.scan, *scan.T_odom_robot)) all.push_back(std::move(event));
  }
  for (doors::DoorEvent& event : detector.Finish()) all.push_back(std::move(event));
  tally.seconds += static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  tally.scans += static_cast<std::int64_t>(scans.size());
  for (const doors::DoorEvent& event : all) {
    tally.latched += event.kind == doors::DoorEvent::Kind::kLatched ? 1 : 0;
    tally.candidates += event.kind == doors::DoorEvent::Kind::kCandidate ? 1 : 0;
  }
  return all;
}

const simulator::TruePose& PoseAt(const simulator::GroundTruth& truth, TimeNs time) {
  const auto found = std::lower_bound(truth.poses.begin(), truth.poses.end(), time,
                                      [](const simulator::TruePose& pose, TimeNs t) { return pose.time < t; });
  return found == truth.poses.end() ? truth.poses.back() : *found;
}

void Score(const Scenario& scenario, const std::vector<doors::DoorEvent>& events, bool list, Tally& tally) {
  const simulator::GroundTruth& truth = scenario.truth;
  std::vector<bool> claimed(truth.passages.size(), false);
  tally.travelled += truth.travelled;
  tally.passages += static_cast<std::int64_t>(truth.passages.size());
  struct Pair {
    double error;  // m
    double cost;   // the same door is often passed twice in short time
    std::size_t event;
    std::size_t passage;
  };
  std::vector<Pair> pairs;
  for (std::size_t e = 0; e < events.size(); ++e) {
    if (events[e].kind != doors::DoorEvent::Kind::kPassage) continue;
    const Pose2 T_campus_robot = PoseAt(truth, events[e].time).T_campus_robot;
    const Eigen::Vector2d door =
        (T_campus_robot * Between(events[e].T_odom_robot, events[e].T_odom_door)).translation();
    for (std::size_t i = 0; i < claimed.size(); ++i) {
      const double late = ToSeconds(events[e].time - truth.passages[i].time);
      const double error = (truth.passages[i].T_campus_robot.translation() - door).norm();
      if (late >= -3.0 && late <= 15.0 && error <= 2.5) pairs.push_back({error, error + 0.2 * std::abs(late), e, i});
    }
  }
  std::sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.cost < b.cost; });
  std::vector<bool> right(events.size(), false);
  for (const Pair& pair : pairs) {
    if (right[pair.event] || claimed[pair.passage]) continue;
    right[pair.event] = claimed[pair.passage] = true;
    tally.errors.push_back(pair.error);
    ++tally.found;
  }
  for (std::size_t e = 0; e < events.size(); ++e) {
    const doors::DoorEvent& event = events[e];
    if (event.kind != doors::DoorEvent::Kind::kPassage) continue;
    tally.false_alarms += right[e] ? 0 : 1;
    if (!list) continue;
    const Pose2 T_campus_robot = PoseAt(truth, event.time).T_campus_robot;
    const Eigen::Vector2d door = (T_campus_robot * Between(event.T_odom_robot, event.T_odom_door)).translation();
    std::cerr << fmt::format("  {} {:.2f} {:.2f} ({:.1f} s) width {:.2f}: {} | {} | {} | {}\n",
                             right[e] ? "right" : "FALSE", door.x(), door.y(),
                             ToSeconds(event.time - truth.poses.front().time), event.width, event.reason,
                             event.ahead.reason, event.behind.reason, event.environment.reason);
  }
  for (std::size_t i = 0; list && i < claimed.size(); ++i) {
    const simulator::TruePassage& passage = truth.passages[i];
    if (claimed[i]) continue;
    std::cerr << fmt::format("  missed {} at {:.2f} {:.2f} ({:.1f} s) width {:.2f} incidence {:.0f} deg, {} to {}\n",
                             passage.door, passage.T_campus_robot.x, passage.T_campus_robot.y,
                             ToSeconds(passage.time - truth.poses.front().time), passage.width,
                             passage.incidence * 180.0 / M_PI, passage.from, passage.to);
  }
}

double Median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

nlohmann::json ToJson(const Tally& tally) {
  return {{"passages", tally.passages},
          {"found", tally.found},
          {"detection_rate",
           tally.passages > 0 ? static_cast<double>(tally.found) / static_cast<double>(tally.passages) : 0.0},
          {"false_alarms", tally.false_alarms},
          {"travelled_m", tally.travelled},
          {"false_alarms_per_100_m",
           tally.travelled > 0.0 ? 100.0 * static_cast<double>(tally.false_alarms) / tally.travelled : 0.0},
          {"latched", tally.latched},
          {"candidates", tally.candidates},
          {"median_door_error_m", Median(tally.errors)},
          {"ms_per_scan", tally.scans > 0 ? 1e3 * tally.seconds / static_cast<double>(tally.scans) : 0.0}};
}

nlohmann::json ScoreRecording(const std::vector<sensor::PairedScan>& scans, const nlohmann::json& doors,
                              const doors::DoorOptions& options, bool list) {
  constexpr double kNear = 6.0;     // s
  constexpr double kTrusted = 1.3;  // m: transitions farther from a plan's door are the plan's errors
  Tally tally;
  const std::vector<doors::DoorEvent> events = Detect(scans, options, tally);
  struct Transition {
    double time;
    bool trusted;
    bool claimed = false;
  };
  std::vector<Transition> transitions;
  for (const auto& one : doors.at("transitions")) {
    transitions.push_back({one.at("time").get<double>(), one.at("dist_m").get<double>() <= kTrusted});
  }
  int told = 0;
  int right = 0;
  int excluded = 0;  // near passages that the plan does not tell reliably
  for (const doors::DoorEvent& event : events) {
    if (event.kind != doors::DoorEvent::Kind::kPassage) continue;
    Transition* match = nullptr;
    const double time = ToSeconds(event.door_time);
    for (Transition& one : transitions) {
      if (one.claimed || std::abs(one.time - time) > kNear) continue;
      if (!match || std::abs(one.time - time) < std::abs(match->time - time)) match = &one;
    }
    if (match) match->claimed = true;
    if (match && !match->trusted) {
      ++excluded;
      continue;
    }
    ++told;
    right += match ? 1 : 0;
    if (list) {
      std::cerr << fmt::format("  {} {:.1f} at odometry {:.2f} {:.2f} width {:.2f}: {} | {} | {} | {}\n",
                               match ? "right" : "WRONG", time, event.T_odom_door.x, event.T_odom_door.y, event.width,
                               event.reason, event.ahead.reason, event.behind.reason, event.environment.reason);
    }
  }
  int trusted = 0;
  int found = 0;
  for (const Transition& one : transitions) {
    if (!one.trusted) continue;
    ++trusted;
    found += one.claimed ? 1 : 0;
    if (list && !one.claimed) std::cerr << fmt::format("  missed {:.1f}\n", one.time);
  }
  return {{"trusted_passages", trusted},
          {"found", found},
          {"recall", trusted > 0 ? static_cast<double>(found) / trusted : 0.0},
          {"told", told},
          {"precision", told > 0 ? static_cast<double>(right) / told : 0.0},
          {"told_near_untrusted_passages", excluded},
          {"latched", tally.latched},
          {"candidates", tally.candidates}};
}

}  // namespace
}  // namespace enfilade::bench

int main(int argc, char** argv) {
  using namespace enfilade;
  using namespace enfilade::bench;
  CLI::App app("Door detection in random buildings and on a recording");
  int buildings = 50;
  std::uint64_t first_seed = 5001;
  std::vector<std::string> presets = doors::DoorPresetNames();
  std::vector<std::string> intel;
  std::string options_file;
  bool list = false;
  simulator::SimulationOptions simulation;
  double field_of_view_deg = 360.0;
  std::string kind = "random";
  app.add_option("--buildings", buildings)->capture_default_str();
  app.add_option("--first-seed", first_seed)->capture_default_str();
  app.add_option("--presets", presets)->delimiter(',');
  app.add_option("--options", options_file, "YAML over each preset");
  app.add_option("--intel", intel, "LOG DOORS")->expected(2);
  app.add_option("--kind", kind, "Of the buildings: random, suites or halls")->capture_default_str();
  app.add_option("--scan-hz", simulation.scan_hz, "Scans of the simulated robots")->capture_default_str();
  app.add_option("--beams", simulation.scanner.beams, "Of each of these scans")->capture_default_str();
  app.add_option("--fov", field_of_view_deg, "Of these scans, degrees")->capture_default_str();
  app.add_flag("--list", list, "Each error on standard error");
  CLI11_PARSE(app, argc, argv);
  simulation.scanner.field_of_view = field_of_view_deg * kDegree;
  const auto fail = [](const absl::Status& status) {
    std::cerr << "bench_doors: " << status.message() << '\n';
    return 1;
  };
  std::string yaml;
  if (!options_file.empty()) {
    std::ifstream file(options_file);
    yaml.assign(std::istreambuf_iterator<char>(file), {});
  }
  std::vector<std::pair<std::string, doors::DoorOptions>> tried;
  for (const std::string& name : presets) {
    absl::StatusOr<doors::DoorOptions> options = doors::DoorPreset(name);
    if (options.ok()) options = doors::ParseDoorOptions(yaml, *options);
    if (!options.ok()) return fail(options.status());
    tried.emplace_back(name, *options);
  }
  std::vector<Tally> tallies(tried.size());
  for (int i = 0; i < buildings; ++i) {
    const std::uint64_t seed = first_seed + static_cast<std::uint64_t>(i);
    const absl::StatusOr<Scenario> scenario = Drive(kind, seed, simulation);
    if (!scenario.ok()) return fail(scenario.status());
    for (std::size_t p = 0; p < tried.size(); ++p) {
      if (list) std::cerr << fmt::format("building {} preset {}\n", seed, tried[p].first);
      Score(*scenario, Detect(scenario->scans, tried[p].second, tallies[p]), list, tallies[p]);
    }
  }
  nlohmann::json report = {{"buildings", buildings}, {"first_seed", first_seed}};
  for (std::size_t p = 0; p < tried.size(); ++p) report["simulated"][tried[p].first] = ToJson(tallies[p]);
  if (!intel.empty()) {
    const auto scans = ReadPairedScans(intel[0], /*odometry=*/true);
    if (!scans.ok()) return fail(scans.status());
    std::ifstream file(intel[1]);
    const nlohmann::json doors = nlohmann::json::parse(file, nullptr, false);
    if (doors.is_discarded()) return fail(absl::InvalidArgumentError(intel[1] + " is no JSON"));
    for (const auto& [name, options] : tried) report["recording"][name] = ScoreRecording(*scans, doors, options, list);
  }
  std::cout << report.dump(2) << '\n';
  return 0;
}
