// SPDX-License-Identifier: Apache-2.0
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/cli/commands/commands.h"
#include "client/cli/output.h"
#include "client/simulator/campus/shipped_campuses.h"
#include "client/simulator/plan/deformed_plan.h"
#include "client/simulator/plan/plan_files.h"
#include "client/simulator/plan/plan_picture.h"
#include "client/simulator/simulation_files.h"
#include "client/sources/formats/json_lines_writer.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/geometry/pose2.h"
#include "fmt/ranges.h"
#include "io/file.h"

namespace enfilade::cli {
namespace {

constexpr double kDefaultFieldOfViewDeg = 360.0;  // of a campus drive
constexpr int kDefaultRoomLaps = 2;

// With a campus: what its robots record, into a folder. Without: the preset, a drive through a few rooms, into one log.
struct SimulateCommandOptions {
  std::string campus;
  std::string output;
  std::vector<std::string> robots;
  std::string truth;
  std::optional<int> beams;
  std::optional<double> field_of_view_deg;
  std::optional<double> range_max;
  std::optional<int> laps;
  std::string plan_output;
  std::optional<std::uint64_t> plan_deform;
  simulator::PlanDeformation plan_errors;  // with plan_deform
  simulator::SimulationOptions simulation;
};

// The options of `base` with what the command line sets. The preset's scanner stays unless an option changes it.
simulator::SimulationOptions SimulationOf(const SimulateCommandOptions& options,
                                          const simulator::ScannerOptions& base) {
  simulator::SimulationOptions simulation = options.simulation;
  simulation.scanner = base;
  if (options.beams) simulation.scanner.beams = *options.beams;
  if (options.field_of_view_deg) simulation.scanner.field_of_view = *options.field_of_view_deg * kDegree;
  if (options.range_max) simulation.scanner.range_max = *options.range_max;
  if (options.laps) simulation.laps = options.laps;
  return simulation;
}

absl::Status WritePlans(const simulator::World& world, const std::map<std::string, simulator::GroundTruth>& drives,
                        const std::filesystem::path& folder) {
  for (const auto& [level, height] : world.campus().levels) {
    ENFILADE_ASSIGN_OR_RETURN(const std::string png, simulator::DrawPlan(world, level, drives));
    const std::string name = world.campus().levels.size() == 1 ? "plan.png" : "plan-" + level + ".png";
    ENFILADE_RETURN_IF_ERROR(io::WriteFile(folder / name, png));
  }
  return absl::OkStatus();
}

void PrintDrives(const Globals& globals, const std::vector<simulator::DriveReport>& reports) {
  nlohmann::json document = nlohmann::json::array();
  for (const simulator::DriveReport& report : reports) {
    document.push_back({{"robot", report.robot},
                        {"log", report.log.string()},
                        {"odometry", report.odometry},
                        {"scans", report.scans},
                        {"images", report.images},
                        {"point_clouds", report.clouds},
                        {"passages", report.truth.passages.size()},
                        {"travelled_m", report.truth.travelled},
                        {"duration_s", report.seconds}});
    if (globals.json || globals.quiet) continue;
    std::cout << fmt::format("{}: {} scans, {} images, {} clouds; {:.1f} m in {}, through {} doors\n",
                             report.log.string(), report.scans, report.images, report.clouds, report.truth.travelled,
                             FormatSeconds(report.seconds), report.truth.passages.size());
  }
  if (globals.json) PrintJson(std::cout, {{"drives", document}});
}

absl::Status SimulateCampus(const Globals& globals, const SimulateCommandOptions& options) {
  if (!options.truth.empty()) {
    return InvalidArgument("--truth: a campus's truth is always written, as ROBOT/truth.txt and ROBOT/truth.jsonl");
  }
  ENFILADE_ASSIGN_OR_RETURN(simulator::Campus campus, simulator::LoadCampus(options.campus));
  if (!options.plan_output.empty()) {
    simulator::PlanDeformation deformation = simulator::PlanDeformation::None();
    if (options.plan_deform) deformation = options.plan_errors;
    if (options.plan_deform) deformation.seed = *options.plan_deform;
    ENFILADE_RETURN_IF_ERROR(simulator::WritePlanFiles(campus, deformation, options.plan_output));
  }
  simulator::ScannerOptions scanner = options.simulation.scanner;
  scanner.field_of_view = kDefaultFieldOfViewDeg * kDegree;
  const simulator::SimulationOptions simulation = SimulationOf(options, scanner);
  const auto world = std::make_shared<const simulator::World>(std::move(campus));
  std::vector<std::string> robots = options.robots;
  if (robots.empty()) {
    for (const simulator::Robot& robot : world->campus().robots) robots.push_back(robot.id);
  }
  if (robots.empty()) return InvalidArgument("{}: the campus has no robots", options.campus);
  const std::filesystem::path folder = options.output;
  std::vector<simulator::DriveReport> reports;
  std::map<std::string, simulator::GroundTruth> drives;
  ProgressBar bar(globals, "driving", static_cast<std::int64_t>(robots.size()));
  for (const std::string& robot : robots) {
    ENFILADE_ASSIGN_OR_RETURN(simulator::DriveReport report,
                              simulator::WriteDrive(world, robot, simulation, folder / robot));
    drives[robot] = report.truth;
    reports.push_back(std::move(report));
    bar.Update(static_cast<std::int64_t>(reports.size()));
  }
  bar.Finish();
  ENFILADE_RETURN_IF_ERROR(WritePlans(*world, drives, folder));
  ENFILADE_RETURN_IF_ERROR(io::WriteFile(folder / "sensors.json", simulator::SensorDescription(simulation)));
  PrintDrives(globals, reports);
  return absl::OkStatus();
}

absl::Status SimulateRooms(const Globals& globals, const SimulateCommandOptions& options) {
  const simulator::SimulationOptions& asked = options.simulation;
  if (!options.robots.empty()) return InvalidArgument("--robots: needs a CAMPUS");
  if (!options.plan_output.empty()) return InvalidArgument("--plan-out: needs a CAMPUS");
  if (asked.image_hz > 0.0 || asked.depth_hz > 0.0 || asked.cloud_hz > 0.0) {
    return InvalidArgument("images, depth images and point clouds need a CAMPUS: without one there is a log only");
  }
  simulator::SimulationOptions simulation = SimulationOf(options, simulator::RoomsOptions().scanner);
  if (!simulation.laps) simulation.laps = kDefaultRoomLaps;
  ENFILADE_ASSIGN_OR_RETURN(const simulator::Drive drive, simulator::SimulateRooms(simulation));
  std::string log = sources::JsonLinesHeader();
  for (const simulator::SimulatedRecord& record : drive.records) {
    ENFILADE_ASSIGN_OR_RETURN(const std::string line, sources::ToJsonLine({record.payload, {}}));
    log += line;
  }
  ENFILADE_RETURN_IF_ERROR(io::WriteFile(options.output, log));
  if (!options.truth.empty()) {
    ENFILADE_RETURN_IF_ERROR(io::WriteFile(options.truth, simulator::TruthTrajectory(drive.truth)));
  }
  const std::size_t scans = drive.truth.poses.size();
  const std::size_t odometry = drive.records.size() - scans;
  const double duration_s = ToSeconds(drive.truth.poses.back().time - drive.truth.poses.front().time);
  if (globals.json) {
    PrintJson(std::cout,
              {{"log", options.output}, {"scans", scans}, {"odometry", odometry}, {"duration_s", duration_s}});
  } else if (!globals.quiet) {
    std::cout << fmt::format("{}: {} scans, {} odometry poses, {} of driving\n", options.output, scans, odometry,
                             FormatSeconds(duration_s));
  }
  return absl::OkStatus();
}

void AddSensors(CLI::App& command, const std::shared_ptr<SimulateCommandOptions>& options) {
  simulator::SimulationOptions& simulation = options->simulation;
  command.add_option("--odometry-hz", simulation.odometry_hz, "Rate of odometry, Hz")->capture_default_str();
  command.add_option("--scan-hz", simulation.scan_hz, "Rate of scans, Hz")->capture_default_str();
  command.add_option("--beams", options->beams, "Beams of a scan (default: 720; without CAMPUS 361)");
  command.add_option("--fov", options->field_of_view_deg,
                     "The scanner's field of view, degrees (default: 360; without CAMPUS 270)");
  command.add_option("--range-max", options->range_max, "The scanner's range, m (default: 100; without CAMPUS 12)");
  command.add_option("--image-hz", simulation.image_hz, "Rate of front and rear images, Hz")->capture_default_str();
  command.add_option("--depth-hz", simulation.depth_hz, "Rate of depth images (16 bits, mm), Hz")
      ->capture_default_str();
  command.add_option("--cloud-hz", simulation.cloud_hz, "Rate of point clouds of 16 rings, Hz")->capture_default_str();
  command.add_option("--near-doors", simulation.near_doors,
                     "Images, depth images and clouds only within this distance of a door, m (0: everywhere)");
  command.add_option("--image-width", simulation.camera.width, "Pixels")->capture_default_str();
  command.add_option("--image-height", simulation.camera.height, "Pixels")->capture_default_str();
}

}  // namespace

void AddSimulate(CLI::App& app, const Globals& globals) {
  auto options = std::make_shared<SimulateCommandOptions>();
  CLI::App* command = AddCommand(
      app, "simulate", "Drive robots through a simulated campus; write their logs and the truth", [&globals, options] {
        return options->campus.empty() ? SimulateRooms(globals, *options) : SimulateCampus(globals, *options);
      });
  command->alias("sim");  // deprecated: its former name
  command->add_option(
      "CAMPUS", options->campus,
      fmt::format("A YAML file (docs/simulator.md), random:SEED, suites:SEED, halls:SEED, NAME.building.yaml of "
                  "Open-RMF, or one of: {}. Without it: a short drive of one robot through three rooms "
                  "(270 degrees, 12 m), as one log file",
                  fmt::join(simulator::ShippedCampusNames(), ", ")));
  command
      ->add_option("-o,--output", options->output,
                   "The folder for ROBOT/log.jsonl, ROBOT/truth.jsonl and plan.png; without CAMPUS, the log file")
      ->required();
  command->add_option("--truth", options->truth, "Without CAMPUS: also write the true poses, lines \"t x y yaw\"");
  command->add_option("--robots", options->robots, "Only these robots, comma-separated")->delimiter(',');
  command->add_option("--seed", options->simulation.seed, "The seed of all noise")->capture_default_str();
  command->add_option("--start-after", options->simulation.start_after,
                      "The robots are switched on at this time of their routes, s");
  command->add_option("--laps", options->laps,
                      "Rounds of each robot's route (default: the campus's; without CAMPUS 2)");
  CLI::Option* plans = command->add_option("--plan-out", options->plan_output,
                                           "Also write floor plans of the campus into this folder, and their truth");
  CLI::Option* deform =
      command
          ->add_option(
              "--plan-deform", options->plan_deform,
              "The seed of what is wrong with these plans: scales, corners, doors, walls left out and invented "
              "(default: they are right)")
          ->needs(plans);
  simulator::PlanDeformation& errors = options->plan_errors;
  command
      ->add_option("--plan-jitter", errors.jitter, "How far their corners are off in x and y, m (standard deviation)")
      ->needs(deform)
      ->check(CLI::Range(0.0, 10.0))
      ->capture_default_str();
  command
      ->add_option("--plan-stretch", errors.stretch,
                   "By how much the strips between walls are too wide (standard deviation of the logarithm)")
      ->needs(deform)
      ->check(CLI::Range(0.0, 0.5))
      ->capture_default_str();
  command->add_option("--plan-left-out", errors.left_out, "The share of walls that they do not have")
      ->needs(deform)
      ->check(CLI::Range(0.0, 0.9))
      ->capture_default_str();
  command->add_option("--plan-invented", errors.invented, "Walls that are not there, by the number of all")
      ->needs(deform)
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  AddSensors(*command, options);
  command->footer(
      "Examples:\n"
      "  enfilade simulate figure1 -o campus --image-hz 2 --cloud-hz 1 --near-doors 4 && "
      "enfilade replay campus/r1/log.jsonl --map M0\n"
      "  enfilade simulate -o drive.jsonl --laps 4 && enfilade replay drive.jsonl --map rooms");
}

}  // namespace enfilade::cli
