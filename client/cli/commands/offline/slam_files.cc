// SPDX-License-Identifier: Apache-2.0
#include "client/cli/commands/offline/slam_files.h"

#include <string>
#include <system_error>
#include <vector>

#include "client/cli/output.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/grid/files/map_files.h"
#include "core/grid/files/rgb_image.h"
#include "io/file.h"

namespace enfilade::cli {
namespace {

const char* NameOf(slam::LoopClosureState state) {
  switch (state) {
    case slam::LoopClosureState::kAccepted:
      return "accepted";
    case slam::LoopClosureState::kSuspended:
      return "suspended";
    default:
      return "rejected";
  }
}

std::string LoopClosuresJson(const slam::SlamMap& map) {
  nlohmann::json closures = nlohmann::json::array();
  for (const auto& [id, closure] : map.loop_closures) {
    const Pose2& T = closure.T_submap_node;
    closures.push_back({{"id", id},
                        {"submap", closure.submap},
                        {"node", closure.node},
                        {"node_time", ToSeconds(map.nodes.at(closure.node).time)},
                        {"state", NameOf(closure.state)},
                        {"score", closure.score},
                        {"chi2", closure.chi2},
                        {"pose_submap_node", {{"x", T.x}, {"y", T.y}, {"yaw", T.yaw}}},
                        {"reason", closure.reason}});
  }
  return nlohmann::json{{"closures", closures}}.dump(2) + "\n";
}

absl::Status WriteMap(const std::filesystem::path& directory, const grid::OccupancyGrid& grid) {
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<grid::MapFile> files,
                            grid::RenderFiles(grid::FromOccupancyGrid(grid), "map", {}));
  for (const grid::MapFile& file : files) ENFILADE_RETURN_IF_ERROR(io::WriteFile(directory / file.name, file.bytes));
  ENFILADE_ASSIGN_OR_RETURN(const std::string png, grid::EncodePng(grid::DrawGrid(grid)));
  return io::WriteFile(directory / "map.png", png);
}

absl::Status WritePlot(const std::filesystem::path& directory, const slam::SlamMap& map,
                       const grid::OccupancyGrid& grid) {
  std::vector<Eigen::Vector2d> path;
  for (const slam::StampedPose& pose : slam::TrajectoryOf(map)) path.push_back(pose.T_map_robot.translation());
  grid::RgbImage image = grid::DrawGrid(grid);
  grid::DrawPath(image, grid.geometry, path, grid::kRed, 2);
  ENFILADE_ASSIGN_OR_RETURN(const std::string png, grid::EncodePng(image));
  return io::WriteFile(directory / "plot.png", png);
}

}  // namespace

std::string TrajectoryText(const slam::SlamMap& map) {
  std::string text;
  for (const slam::StampedPose& pose : slam::TrajectoryOf(map)) {
    text += fmt::format("{}.{:09d} {} {} {}\n", pose.time / kNsPerSecond, pose.time % kNsPerSecond, pose.T_map_robot.x,
                        pose.T_map_robot.y, pose.T_map_robot.yaw);
  }
  return text;
}

absl::Status WriteSlamFiles(const std::filesystem::path& directory, const slam::SlamMap& map,
                            const grid::OccupancyGrid& grid, bool plot) {
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  if (error) return FailedPrecondition("{}: the folder cannot be created: {}", directory.string(), error.message());
  ENFILADE_RETURN_IF_ERROR(io::WriteFile(directory / "trajectory.txt", TrajectoryText(map)));
  ENFILADE_RETURN_IF_ERROR(io::WriteFile(directory / "closures.json", LoopClosuresJson(map)));
  if (grid.cells.empty()) return absl::OkStatus();
  ENFILADE_RETURN_IF_ERROR(WriteMap(directory, grid));
  return plot ? WritePlot(directory, map, grid) : absl::OkStatus();
}

}  // namespace enfilade::cli
