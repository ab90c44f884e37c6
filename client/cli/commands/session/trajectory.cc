// SPDX-License-Identifier: Apache-2.0
#include "client/sdk/api/trajectory.h"

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "client/cli/commands/commands.h"
#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "client/sdk/api/world_trajectory.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/base/time.h"
#include "core/geometry/pose2.h"
#include "fmt/ranges.h"

namespace enfilade::cli {
namespace {

struct TrajectoryCommandOptions {
  std::string session;
  std::string robot;
  bool world = false;
  std::string output;
};

// The lines of a trajectory, on standard output or in a file.
class TrajectoryFile {
 public:
  static absl::StatusOr<std::unique_ptr<TrajectoryFile>> Open(const std::string& path) {
    auto opened = std::make_unique<TrajectoryFile>();
    opened->path_ = path;
    if (path == "-") return opened;
    opened->file_.open(path, std::ios::binary | std::ios::trunc);
    if (!opened->file_) return InvalidArgument("{}: cannot be written", path);
    return opened;
  }
  void Write(std::int64_t seconds, std::int64_t nanoseconds, const Pose2& pose) {
    out() << fmt::format("{}.{:09d} {} {} {}\n", seconds, nanoseconds, pose.x, pose.y, pose.yaw);
    ++poses_;
  }
  // Reports how many poses were written. `more`: further members of the JSON.
  absl::Status Close(const Globals& globals, const nlohmann::json& more = nlohmann::json::object()) {
    out().flush();
    if (!out()) return ResourceExhausted("{}: cannot be written: is the disk full?", path_);
    if (path_ == "-") return absl::OkStatus();
    if (!globals.json) {
      std::cout << poses_ << " poses in " << path_ << '\n';
      return absl::OkStatus();
    }
    nlohmann::json document = {{"poses", poses_}, {"file", path_}};
    document.update(more);
    PrintJson(std::cout, document);
    return absl::OkStatus();
  }

 private:
  std::ostream& out() { return path_ == "-" ? std::cout : file_; }

  std::string path_;
  std::ofstream file_;
  std::int64_t poses_ = 0;
};

absl::Status ExportSession(const Globals& globals, const TrajectoryCommandOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(const std::unique_ptr<TrajectoryFile> file, TrajectoryFile::Open(options.output));
  const auto write = [&file](const v1::TrajectoryPose& pose) {
    const v1::Pose2& T_map_robot = pose.pose_map_robot();
    file->Write(pose.time().seconds(), pose.time().nanos(), {T_map_robot.x(), T_map_robot.y(), T_map_robot.yaw()});
    return absl::OkStatus();
  };
  ENFILADE_RETURN_IF_ERROR(
      client::ExportTrajectory(ConnectionOf(globals), ResourceNameOf(globals, "sessions", options.session), write)
          .status());
  return file->Close(globals);
}

// Names what has no place in the world: each map once, and sessions that are in no map.
std::vector<std::string> LeftOut(const client::WorldTrajectory& trajectory) {
  std::vector<std::string> names;
  for (const client::MappedStretch& stretch : trajectory.left_out) {
    const std::string name = stretch.map.empty()        ? "session " + IdOf(stretch.session) + ", which is in no map"
                             : stretch.map_name.empty() ? "map " + IdOf(stretch.map)
                                                        : "map \"" + stretch.map_name + "\"";
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  return names;
}

absl::Status ExportRobot(const Globals& globals, const TrajectoryCommandOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(
      const std::vector<client::MappedStretch> stretches,
      client::ReadStretches(ConnectionOf(globals), ResourceNameOf(globals, "robots", options.robot)));
  const client::WorldTrajectory trajectory = client::JoinStretches(stretches);
  ENFILADE_ASSIGN_OR_RETURN(const std::unique_ptr<TrajectoryFile> file, TrajectoryFile::Open(options.output));
  for (const client::WorldPose& pose : trajectory.poses) {
    file->Write(pose.time / kNsPerSecond, pose.time % kNsPerSecond, pose.T_world_robot);
  }
  const std::vector<std::string> left_out = LeftOut(trajectory);
  std::size_t poses = 0;
  for (const client::MappedStretch& stretch : trajectory.left_out) poses += stretch.poses.size();
  ENFILADE_RETURN_IF_ERROR(
      file->Close(globals, {{"sessions", stretches.size()}, {"left_out", left_out}, {"left_out_poses", poses}}));
  if (left_out.empty()) return absl::OkStatus();
  return FailedPrecondition("{} poses are left out, because no link points join these to the world: {}", poses,
                            fmt::join(left_out, "; "));
}

absl::Status ExportTrajectory(const Globals& globals, const TrajectoryCommandOptions& options) {
  if (options.session.empty() == options.robot.empty()) {
    return InvalidArgument("give one of them: a SESSION, or --robot for all its sessions");
  }
  if (options.robot.empty() != !options.world) {
    return InvalidArgument(
        "--robot and --world go together: a robot's sessions are in several maps, one session is in its map's frame");
  }
  return options.robot.empty() ? ExportSession(globals, options) : ExportRobot(globals, options);
}

}  // namespace

void AddTrajectory(CLI::App& app, const Globals& globals) {
  CLI::App* trajectory = app.add_subcommand("trajectory", "Where robots have driven");
  trajectory->require_subcommand(1);
  auto options = std::make_shared<TrajectoryCommandOptions>();
  CLI::App* export_command =
      AddCommand(*trajectory, "export", "Write every mapped scan's pose: lines `t x y yaw` (absolute seconds, m, rad)",
                 [&globals, options] { return ExportTrajectory(globals, *options); });
  export_command->add_option("SESSION", options->session,
                             "The session's id or resource name: poses in its map's frame");
  export_command->add_option("--robot", options->robot,
                             "All sessions of this robot, one after the other: needs --world");
  export_command->add_flag("--world", options->world,
                           "Poses in the world frame. Maps without a place in the world are left out and named, and "
                           "the exit code is 1");
  export_command->add_option("-o,--output", options->output, "The file; - for standard output")->required();
  export_command->footer(
      "Examples:\n"
      "  enfilade trajectory export 5d0c... -o trajectory.txt\n"
      "  enfilade trajectory export --robot r1 --world -o r1.txt");
}

}  // namespace enfilade::cli
