// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/cli/commands/commands.h"
#include "client/cli/commands/offline/rooms_picture.h"
#include "client/cli/map_file_reader.h"
#include "client/cli/output.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/grid/files/map_files.h"
#include "core/grid/files/plan_image.h"
#include "core/grid/map_raster.h"
#include "core/rooms/room_partition.h"
#include "fmt/format.h"
#include "io/file.h"

namespace enfilade::cli {
namespace {

struct RoomsCommandOptions {
  std::string map;
  std::string output;
  std::string plot;
  std::optional<double> resolution;
};

absl::StatusOr<grid::OccupancyGrid> ReadMap(const RoomsCommandOptions& options) {
  const std::string extension = std::filesystem::path(options.map).extension().string();
  grid::OccupancyGrid grid;
  if (extension == ".yaml" || extension == ".yml" || extension == ".json") {
    ENFILADE_ASSIGN_OR_RETURN(const std::vector<grid::MapFile> files, ReadMapFiles(options.map));
    ENFILADE_ASSIGN_OR_RETURN(const grid::ImportedMap map, grid::ImportFiles(files, grid::MapDialect::kNav2));
    grid = grid::ToOccupancyGrid(map.raster);
  } else {
    ENFILADE_ASSIGN_OR_RETURN(const std::string bytes, io::ReadFile(options.map));
    absl::StatusOr<grid::OccupancyGrid> plan = grid::ReadPlan(bytes);
    if (!plan.ok()) return WithContext(plan.status(), options.map);
    grid = *std::move(plan);
  }
  if (options.resolution) grid.geometry.resolution = *options.resolution;
  const absl::Status valid = grid::Validate(grid.geometry);
  if (!valid.ok()) return WithContext(valid, options.map);
  return grid;
}

nlohmann::json PointJson(const Eigen::Vector2d& p) { return {{"x_m", p.x()}, {"y_m", p.y()}}; }

void PrintRooms(const Globals& globals, const rooms::RoomPartition& partition) {
  if (globals.json) {
    nlohmann::json document = {{"rooms", nlohmann::json::array()}, {"doors", nlohmann::json::array()}};
    for (const rooms::Room& room : partition.rooms) {
      document["rooms"].push_back({{"id", room.id}, {"area_m2", room.area_m2}, {"centre", PointJson(room.centre)}});
    }
    for (const rooms::Door& door : partition.doors) {
      document["doors"].push_back(
          {{"a", PointJson(door.a)}, {"b", PointJson(door.b)}, {"rooms", door.rooms}, {"width_m", door.width()}});
    }
    return PrintJson(std::cout, document);
  }
  std::vector<std::vector<std::string>> rows;
  for (const rooms::Room& room : partition.rooms) {
    std::string doors;
    for (const rooms::Door& door : partition.doors) {
      if (door.rooms[0] != room.id && door.rooms[1] != room.id) continue;
      doors += fmt::format("{}{}", doors.empty() ? "" : " ", door.rooms[0] == room.id ? door.rooms[1] : door.rooms[0]);
    }
    rows.push_back({fmt::format("{}", room.id), fmt::format("{:.1f}", room.area_m2),
                    fmt::format("{:.2f} {:.2f}", room.centre.x(), room.centre.y()), doors});
  }
  PrintTable(std::cout, {"ROOM", "AREA M2", "CENTRE M", "DOORS TO"}, rows);
}

absl::Status RunRooms(const Globals& globals, const RoomsCommandOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(const grid::OccupancyGrid grid, ReadMap(options));
  const rooms::RoomPartition partition = rooms::PartitionRooms(grid);
  PrintRooms(globals, partition);
  if (!options.output.empty()) {
    ENFILADE_ASSIGN_OR_RETURN(const std::string png, EncodeLabels(partition));
    ENFILADE_RETURN_IF_ERROR(io::WriteFile(options.output, png));
  }
  if (options.plot.empty()) return absl::OkStatus();
  ENFILADE_ASSIGN_OR_RETURN(const std::string png, grid::EncodePng(DrawRooms(grid, partition)));
  return io::WriteFile(options.plot, png);
}

}  // namespace

void AddRooms(CLI::App& app, const Globals& globals) {
  auto options = std::make_shared<RoomsCommandOptions>();
  CLI::App* command = AddCommand(app, "rooms", "Cut a finished map into its rooms and find the doors between them",
                                 [&globals, options] { return RunRooms(globals, *options); });
  command->add_option("MAP", options->map, "A map's YAML or JSON file, or a picture (PNG or PGM)")->required();
  command->add_option("--resolution", options->resolution,
                      "Metres per pixel (default: the YAML file's; of a picture 0.05)");
  command->add_option("-o,--output", options->output,
                      "Write a PNG of the map's size: 0 where there is no room, else the room's number; 16 bits if "
                      "there are more than 255 rooms");
  command->add_option("--plot", options->plot, "Write a PNG that shows the rooms in colours and the doors");
  command->footer("Example:\n  enfilade rooms map.yaml -o rooms.png --plot plot.png");
}

}  // namespace enfilade::cli
