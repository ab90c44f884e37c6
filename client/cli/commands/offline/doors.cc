// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "client/cli/commands/commands.h"
#include "client/cli/commands/offline/doors_plot.h"
#include "client/cli/log_mapping.h"
#include "client/cli/log_options.h"
#include "client/cli/output.h"
#include "client/sources/log_reader.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/doors/door_detector.h"
#include "core/sensor/scan_pairing.h"
#include "io/file.h"

namespace enfilade::cli {
namespace {

struct DoorsCommandOptions {
  std::string log;
  std::string preset = "default";
  std::string options_file;
  std::string plot;
  bool print_options = false;
  sources::LogOptions reading;
};

absl::StatusOr<doors::DoorOptions> LoadDoorOptions(const DoorsCommandOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(const doors::DoorOptions preset, doors::DoorPreset(options.preset));
  if (options.options_file.empty()) return preset;
  ENFILADE_ASSIGN_OR_RETURN(const std::string text, io::ReadFile(options.options_file));
  absl::StatusOr<doors::DoorOptions> parsed = doors::ParseDoorOptions(text, preset);
  if (!parsed.ok()) return WithContext(parsed.status(), options.options_file);
  return parsed;
}

absl::StatusOr<std::vector<sensor::PairedScan>> ReadScansWithOdometry(const DoorsCommandOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(sources::LogReader reader, sources::LogReader::Open(options.log, options.reading));
  ENFILADE_ASSIGN_OR_RETURN(std::vector<sensor::PairedScan> scans, ReadScans(reader));
  const std::size_t all = scans.size();
  std::erase_if(scans, [](const sensor::PairedScan& scan) { return !scan.T_odom_robot; });
  if (scans.empty()) {
    return FailedPrecondition("{}: none of {} scans has odometry close to it in time, which finding doors needs",
                              options.log, all);
  }
  return scans;
}

nlohmann::json ToJson(const Pose2& pose) { return {{"x_m", pose.x}, {"y_m", pose.y}, {"yaw_rad", pose.yaw}}; }

nlohmann::json ToJson(const doors::CriterionVerdict& verdict) {
  constexpr const char* kStates[] = {"open", "met", "dropped"};
  return {{"state", kStates[static_cast<int>(verdict.state)]}, {"reason", verdict.reason}};
}

nlohmann::json ToJson(const doors::DoorEvent& event) {
  nlohmann::json json = {{"event", doors::NameOf(event.kind)},
                         {"time_ns", event.time},
                         {"door", event.door},
                         {"pose_odom_robot", ToJson(event.T_odom_robot)},
                         {"pose_odom_door", ToJson(event.T_odom_door)},
                         {"door_time_ns", event.door_time},
                         {"ahead", ToJson(event.ahead)},
                         {"behind", ToJson(event.behind)},
                         {"environment", ToJson(event.environment)},
                         {"reason", event.reason}};
  if (event.width > 0.0) json["width_m"] = event.width;
  if (event.T_odom_gap) json["pose_odom_gap"] = ToJson(*event.T_odom_gap);
  return json;
}

absl::Status RunDoors(const Globals& globals, const DoorsCommandOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(const doors::DoorOptions doors, LoadDoorOptions(options));
  if (options.print_options) {
    std::cout << doors::FormatDoorOptions(doors);
    return absl::OkStatus();
  }
  if (options.log.empty()) return InvalidArgument("doors: LOG is missing (see enfilade doors --help)");
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<sensor::PairedScan> scans, ReadScansWithOdometry(options));
  ProgressBar bar(globals, "looking for doors", static_cast<std::int64_t>(scans.size()));
  doors::DoorDetector detector(doors);
  std::vector<doors::DoorEvent> events;
  const auto print = [&](std::vector<doors::DoorEvent> some) {
    for (doors::DoorEvent& event : some) {
      std::cout << ToJson(event).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) << '\n';
      events.push_back(std::move(event));
    }
  };
  for (std::size_t i = 0; i < scans.size(); ++i) {
    print(detector.Add(scans[i].scan, *scans[i].T_odom_robot));
    bar.Update(static_cast<std::int64_t>(i) + 1);
  }
  print(detector.Finish());
  bar.Finish();
  if (options.plot.empty()) return absl::OkStatus();
  ENFILADE_ASSIGN_OR_RETURN(const std::string png, DrawDoors(scans, events, doors.derivative));
  return io::WriteFile(options.plot, png);
}

}  // namespace

void AddDoors(CLI::App& app, const Globals& globals) {
  auto options = std::make_shared<DoorsCommandOptions>();
  CLI::App* command = AddCommand(app, "doors", "Find doors and the passages through them in a recorded log",
                                 [&globals, options] { return RunDoors(globals, *options); });
  command->add_option("LOG", options->log, "The log (docs/logs.md lists the formats)");
  command->add_option("--preset", options->preset, "default, original-yaml or original-code")->capture_default_str();
  command->add_option("--options", options->options_file,
                      "A YAML file with options that override the preset (docs/doors.md)");
  command->add_option("--plot", options->plot, "Write a PNG: the derivative of the scans, the path, and the decisions");
  command->add_flag("--print-options", options->print_options, "Print all options as YAML and exit");
  AddLogOptions(*command, options->reading);
  command->footer("Example:\n  enfilade doors drive.jsonl --plot doors.png");
}

}  // namespace enfilade::cli
