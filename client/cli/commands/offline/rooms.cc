// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/cli/commands/commands.h"
#include "client/cli/commands/offline/rooms_picture.h"
#include "client/cli/occupancy_map.h"
#include "client/cli/output.h"
#include "core/base/status_macros.h"
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
  ENFILADE_ASSIGN_OR_RETURN(const grid::OccupancyGrid grid, ReadOccupancyMap(options.map, options.resolution));
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
