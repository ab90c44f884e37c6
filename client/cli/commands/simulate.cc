#include "client/cli/commands/simulate.h"

#include <fstream>
#include <iostream>
#include <memory>
#include <string>

#include "client/cli/output.h"
#include "client/simulator/drive.h"
#include "client/sources/json_lines_writer.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace enfilade::cli {
namespace {

struct Options {
  std::string output;
  std::string truth;
  simulator::DriveOptions drive;
};

absl::Status Flushed(std::ofstream& file, const std::string& path) {
  file.close();
  if (file) return absl::OkStatus();
  return FailedPrecondition("{}: cannot be written (no such folder, no permission, or the disk is full)", path);
}

absl::Status WriteLog(const simulator::Drive& drive, const std::string& path) {
  std::ofstream file(path, std::ios::binary);
  file << sources::JsonLinesHeader();
  for (const sources::LogEntry& entry : drive.entries) {
    ENFILADE_ASSIGN_OR_RETURN(const std::string line, sources::ToJsonLine(entry));
    file << line;
  }
  return Flushed(file, path);
}

// As `enfilade trajectory export`: t x y yaw.
absl::Status WriteTruth(const simulator::Drive& drive, const std::string& path) {
  std::ofstream file(path, std::ios::binary);
  for (const simulator::TruePose& pose : drive.truth) {
    file << fmt::format("{}.{:09d} {} {} {}\n", pose.time / kNsPerSecond, pose.time % kNsPerSecond, pose.T_plan_robot.x,
                        pose.T_plan_robot.y, pose.T_plan_robot.yaw);
  }
  return Flushed(file, path);
}

absl::Status Run(const Globals& globals, const Options& options) {
  ENFILADE_ASSIGN_OR_RETURN(const simulator::Drive drive,
                            simulator::SimulateDrive(simulator::EnfiladePlan(), options.drive));
  ENFILADE_RETURN_IF_ERROR(WriteLog(drive, options.output));
  if (!options.truth.empty()) ENFILADE_RETURN_IF_ERROR(WriteTruth(drive, options.truth));
  const std::size_t scans = drive.truth.size();
  const std::size_t odometry = drive.entries.size() - scans;
  const double duration_s = ToSeconds(drive.truth.back().time - drive.truth.front().time);
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
  auto options = std::make_shared<Options>();
  CLI::App* command = AddCommand(app, "simulate", "Write the log of a simulated drive through a few rooms",
                                 [&globals, options] { return Run(globals, *options); });
  command->add_option("-o,--output", options->output, "The log to write (JSON lines)")->required();
  command->add_option("--truth", options->truth, "Also write the true poses: lines \"t x y yaw\"");
  command->add_option("--seed", options->drive.seed, "Of all noise")->capture_default_str();
  command->add_option("--laps", options->drive.laps, "Rounds through the rooms")->capture_default_str();
  command->footer("Example:\n  enfilade simulate -o drive.jsonl --laps 2 && enfilade replay drive.jsonl --map rooms");
}

}  // namespace enfilade::cli
