// SPDX-License-Identifier: Apache-2.0
#include "client/sdk/api/trajectory.h"

#include <fstream>
#include <iostream>
#include <memory>
#include <string>

#include "client/cli/commands/commands.h"
#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace enfilade::cli {
namespace {

struct TrajectoryCommandOptions {
  std::string session;
  std::string output;
};

absl::Status ExportTrajectory(const Globals& globals, const TrajectoryCommandOptions& options) {
  const bool to_stdout = options.output == "-";
  std::ofstream file;
  if (!to_stdout) {
    file.open(options.output, std::ios::binary | std::ios::trunc);
    if (!file) return InvalidArgument("{}: cannot be written", options.output);
  }
  std::ostream& out = to_stdout ? std::cout : file;
  const auto write = [&out](const v1::TrajectoryPose& pose) {
    out << fmt::format("{}.{:09d} {} {} {}\n", pose.time().seconds(), pose.time().nanos(), pose.pose_map_robot().x(),
                       pose.pose_map_robot().y(), pose.pose_map_robot().yaw());
    return absl::OkStatus();
  };
  ENFILADE_ASSIGN_OR_RETURN(
      const std::int64_t poses,
      client::ExportTrajectory(ConnectionOf(globals), ResourceNameOf(globals, "sessions", options.session), write));
  out.flush();
  if (!out) return ResourceExhausted("{}: cannot be written: is the disk full?", options.output);
  if (globals.json && !to_stdout) PrintJson(std::cout, {{"poses", poses}, {"file", options.output}});
  if (!globals.json && !to_stdout) std::cout << poses << " poses in " << options.output << '\n';
  return absl::OkStatus();
}

}  // namespace

void AddTrajectory(CLI::App& app, const Globals& globals) {
  CLI::App* trajectory = app.add_subcommand("trajectory", "The trajectory of a session's robot");
  trajectory->require_subcommand(1);
  auto options = std::make_shared<TrajectoryCommandOptions>();
  CLI::App* export_command =
      AddCommand(*trajectory, "export", "Write every mapped scan's pose: lines `t x y yaw` (absolute seconds, m, rad)",
                 [&globals, options] { return ExportTrajectory(globals, *options); });
  export_command->add_option("SESSION", options->session, "The session's id or resource name")->required();
  export_command->add_option("-o,--output", options->output, "The file; - for standard output")->required();
  export_command->footer("Example: enfilade trajectory export 5d0c... -o trajectory.txt");
}

}  // namespace enfilade::cli
