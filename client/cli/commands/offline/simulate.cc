// SPDX-License-Identifier: Apache-2.0
#include "client/cli/commands/offline/simulate.h"

#include <iostream>
#include <memory>
#include <string>

#include "client/cli/output.h"
#include "client/simulator/simulation_files.h"
#include "client/sources/formats/json_lines_writer.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "io/file.h"

namespace enfilade::cli {
namespace {

struct SimulateCommandOptions {
  std::string output;
  std::string truth;
  simulator::SimulationOptions simulation = simulator::RoomsOptions();
  int laps = 2;
};

absl::Status RunSimulate(const Globals& globals, SimulateCommandOptions options) {
  options.simulation.laps = options.laps;
  ENFILADE_ASSIGN_OR_RETURN(const simulator::Drive drive, simulator::SimulateRooms(options.simulation));
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
                             SecondsInWords(duration_s));
  }
  return absl::OkStatus();
}

}  // namespace

void AddSimulate(CLI::App& app, const Globals& globals) {
  auto options = std::make_shared<SimulateCommandOptions>();
  CLI::App* command =
      AddCommand(app, "simulate", "Write the log of a simulated drive through a few rooms (a preset of sim)",
                 [&globals, options] { return RunSimulate(globals, *options); });
  command->add_option("-o,--output", options->output, "The log to write (JSON lines)")->required();
  command->add_option("--truth", options->truth, "Also write the true poses: lines \"t x y yaw\"");
  command->add_option("--seed", options->simulation.seed, "Of all noise")->capture_default_str();
  command->add_option("--laps", options->laps, "Rounds through the rooms")->capture_default_str();
  command->footer("Example:\n  enfilade simulate -o drive.jsonl --laps 2 && enfilade replay drive.jsonl --map rooms");
}

}  // namespace enfilade::cli
