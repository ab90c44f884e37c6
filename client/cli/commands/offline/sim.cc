// SPDX-License-Identifier: Apache-2.0
#include "client/cli/commands/offline/sim.h"

#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "client/cli/output.h"
#include "client/simulator/campus/shipped_campuses.h"
#include "client/simulator/plan_picture.h"
#include "client/simulator/simulation_files.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/geometry/pose2.h"
#include "fmt/ranges.h"
#include "io/file.h"

namespace enfilade::cli {
namespace {

struct SimCommandOptions {
  std::string campus;
  std::string output;
  std::vector<std::string> robots;
  double field_of_view_deg = 360.0;
  int laps = 0;
  simulator::SimulationOptions simulation;
};

absl::Status WritePlans(const simulator::World& world, const std::map<std::string, simulator::GroundTruth>& drives,
                        const std::filesystem::path& folder) {
  for (const auto& [level, height] : world.campus().levels) {
    ENFILADE_ASSIGN_OR_RETURN(const std::string png, simulator::DrawPlan(world, level, drives));
    const std::string name = world.campus().levels.size() == 1 ? "plan.png" : "plan-" + level + ".png";
    ENFILADE_RETURN_IF_ERROR(io::WriteFile(folder / name, png));
  }
  return absl::OkStatus();
}

void PrintSim(const Globals& globals, const std::vector<simulator::DriveReport>& reports) {
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
                             SecondsInWords(report.seconds), report.truth.passages.size());
  }
  if (globals.json) PrintJson(std::cout, {{"drives", document}});
}

absl::Status RunSim(const Globals& globals, SimCommandOptions options) {
  ENFILADE_ASSIGN_OR_RETURN(simulator::Campus campus, simulator::LoadCampus(options.campus));
  options.simulation.scanner.field_of_view = options.field_of_view_deg * kDegree;
  if (options.laps > 0) options.simulation.laps = options.laps;
  const auto world = std::make_shared<const simulator::World>(std::move(campus));
  if (options.robots.empty()) {
    for (const simulator::Robot& robot : world->campus().robots) options.robots.push_back(robot.id);
  }
  if (options.robots.empty()) return InvalidArgument("{}: the campus has no robots", options.campus);
  std::vector<simulator::DriveReport> reports;
  std::map<std::string, simulator::GroundTruth> drives;
  ProgressBar bar(globals, "driving", static_cast<std::int64_t>(options.robots.size()));
  for (const std::string& robot : options.robots) {
    ENFILADE_ASSIGN_OR_RETURN(
        simulator::DriveReport report,
        simulator::WriteDrive(world, robot, options.simulation, std::filesystem::path(options.output) / robot));
    drives[robot] = report.truth;
    reports.push_back(std::move(report));
    bar.Update(static_cast<std::int64_t>(reports.size()));
  }
  bar.Finish();
  ENFILADE_RETURN_IF_ERROR(WritePlans(*world, drives, options.output));
  ENFILADE_RETURN_IF_ERROR(io::WriteFile(std::filesystem::path(options.output) / "sensors.json",
                                         simulator::SensorDescription(options.simulation)));
  PrintSim(globals, reports);
  return absl::OkStatus();
}

}  // namespace

void AddSim(CLI::App& app, const Globals& globals) {
  auto options = std::make_shared<SimCommandOptions>();
  simulator::SimulationOptions& simulation = options->simulation;
  CLI::App* command =
      AddCommand(app, "sim", "Drive robots through a simulated campus and write their logs and the truth",
                 [&globals, options] { return RunSim(globals, *options); });
  command
      ->add_option("CAMPUS", options->campus,
                   fmt::format("A YAML file (docs/simulator.md), random:SEED, or one of: {}",
                               fmt::join(simulator::ShippedCampusNames(), ", ")))
      ->required();
  command->add_option("-o,--output", options->output, "The folder: ROBOT/log.jsonl, ROBOT/truth.jsonl, plan.png")
      ->required();
  command->add_option("--robots", options->robots, "Only these, comma-separated")->delimiter(',');
  command->add_option("--seed", simulation.seed, "Of all noise")->capture_default_str();
  command->add_option("--laps", options->laps, "Rounds of each robot's route, instead of the campus's");
  command->add_option("--odometry-hz", simulation.odometry_hz)->capture_default_str();
  command->add_option("--scan-hz", simulation.scan_hz)->capture_default_str();
  command->add_option("--beams", simulation.scanner.beams)->capture_default_str();
  command->add_option("--fov", options->field_of_view_deg, "The scanner's field of view, degrees")
      ->capture_default_str();
  command->add_option("--range-max", simulation.scanner.range_max, "m")->capture_default_str();
  command->add_option("--image-hz", simulation.image_hz, "Front and rear images")->capture_default_str();
  command->add_option("--depth-hz", simulation.depth_hz, "Depth images (16 bit, mm)")->capture_default_str();
  command->add_option("--cloud-hz", simulation.cloud_hz, "Point clouds of 16 rings")->capture_default_str();
  command->add_option("--near-doors", simulation.near_doors, "Images, depth and clouds only this near to a door, m");
  command->add_option("--image-width", simulation.camera.width)->capture_default_str();
  command->add_option("--image-height", simulation.camera.height)->capture_default_str();
  command->footer(
      "Example:\n  enfilade sim figure1 -o campus --image-hz 2 --cloud-hz 1 --near-doors 4 && "
      "enfilade replay campus/r1/log.jsonl --map M0");
}

}  // namespace enfilade::cli
