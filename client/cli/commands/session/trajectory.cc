// SPDX-License-Identifier: Apache-2.0
#include "client/cli/commands/session/trajectory.h"

#include <fstream>
#include <iostream>
#include <memory>

#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "enfilade/v1/session_service.grpc.pb.h"

namespace enfilade::cli {
namespace {

struct TrajectoryCommandOptions {
  std::string session;
  std::string output;
};

absl::StatusOr<std::int64_t> ReceiveTrajectory(const client::Connection& connection,
                                               const v1::ExportTrajectoryRequest& request, std::ostream& out) {
  v1::SessionService::Stub stub(connection.channel());
  grpc::ClientContext context;
  const auto reader = stub.ExportTrajectory(&context, request);
  v1::ExportTrajectoryResponse part;
  std::int64_t poses = 0;
  while (reader->Read(&part)) {
    for (const v1::TrajectoryPose& pose : part.poses()) {
      out << fmt::format("{}.{:09d} {} {} {}\n", pose.time().seconds(), pose.time().nanos(), pose.pose_map_robot().x(),
                         pose.pose_map_robot().y(), pose.pose_map_robot().yaw());
      ++poses;
    }
  }
  ENFILADE_RETURN_IF_ERROR(client::FromGrpcStatus(reader->Finish(), connection.address()));
  return poses;
}

absl::Status ExportTrajectory(const Globals& globals, const TrajectoryCommandOptions& options) {
  v1::ExportTrajectoryRequest request;
  request.set_name(SessionNameOf(globals, options.session));
  const bool to_stdout = options.output == "-";
  std::ofstream file;
  if (!to_stdout) {
    file.open(options.output, std::ios::binary | std::ios::trunc);
    if (!file) return InvalidArgument("cannot write to {}", options.output);
  }
  std::ostream& out = to_stdout ? std::cout : file;
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t poses, ReceiveTrajectory(ConnectionOf(globals), request, out));
  out.flush();
  if (!out) return ResourceExhausted("{} could not be written: is the disk full?", options.output);
  if (globals.json && !to_stdout) PrintJson(std::cout, {{"poses", poses}, {"file", options.output}});
  if (!globals.json && !to_stdout) std::cout << poses << " poses in " << options.output << '\n';
  return absl::OkStatus();
}

}  // namespace

void AddTrajectory(CLI::App& app, const Globals& globals) {
  CLI::App* trajectory = app.add_subcommand("trajectory", "Where a robot was");
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
