// SPDX-License-Identifier: Apache-2.0
// `enfilade area list`, `show`, `delete` and `export`.
#include <iostream>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "client/cli/commands/area/area_fields.h"
#include "client/cli/commands/area/area_output.h"
#include "client/cli/commands/commands.h"
#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "client/sdk/editing/map_areas.h"
#include "core/base/status_macros.h"
#include "enfilade/v1/map_area_service.grpc.pb.h"
#include "fmt/format.h"

namespace enfilade::cli {
namespace {

using MapAreaStub = v1::MapAreaService::Stub;

struct AreaOptions {
  std::string map;
  std::string area;
};

struct AreaExportOptions {
  std::string map;
  std::string directory;
  std::string format = "geojson";
  std::string robot_type;
  std::string at;
};

const std::map<std::string, v1::MapAreaFormat>& AreaFormats() {
  static const std::map<std::string, v1::MapAreaFormat> formats = {{"geojson", v1::MAP_AREA_FORMAT_GEOJSON},
                                                                   {"nav2-keepout", v1::MAP_AREA_FORMAT_NAV2_KEEPOUT},
                                                                   {"nav2-speed", v1::MAP_AREA_FORMAT_NAV2_SPEED}};
  return formats;
}

absl::StatusOr<v1::MapArea> FindAreaOf(const Globals& globals, const client::Connection& connection,
                                       const AreaOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(const v1::Map map, FindMap(connection, globals, options.map));
  return client::FindMapArea(connection, map.name(), options.area);
}

absl::Status ListAreas(const Globals& globals, const AreaOptions& options) {
  const client::Connection connection = ConnectionOf(globals);
  ENFILADE_ASSIGN_OR_RETURN(const v1::Map map, FindMap(connection, globals, options.map));
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<v1::MapArea> listed, client::ListMapAreas(connection, map.name()));
  PrintList<v1::MapArea>(globals, listed, MapAreaHeader(), MapAreaToJson, MapAreaRow);
  return absl::OkStatus();
}

absl::Status ShowArea(const Globals& globals, const AreaOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(const v1::MapArea area, FindAreaOf(globals, ConnectionOf(globals), options));
  if (globals.json) {
    PrintJson(std::cout, MapAreaToJson(area));
    return absl::OkStatus();
  }
  std::cout << area.display_name() << '\n' << area.name() << "  " << KindText(area.kind());
  if (area.speed_limit_mps() > 0.0) std::cout << ", " << area.speed_limit_mps() << " m/s";
  std::cout << "\nrobots: ";
  if (area.robot_types().empty()) std::cout << "all";
  for (int i = 0; i < area.robot_types_size(); ++i) std::cout << (i == 0 ? "" : ", ") << area.robot_types(i);
  std::cout << "\nholds: " << ValidityText(area) << "\ncorners:";
  for (const v1::Point& corner : area.outline().corners()) std::cout << fmt::format(" {},{}", corner.x(), corner.y());
  std::cout << '\n';
  return absl::OkStatus();
}

absl::Status DeleteArea(const Globals& globals, const AreaOptions& options) {
  const client::Connection connection = ConnectionOf(globals);
  ENFILADE_ASSIGN_OR_RETURN(const v1::MapArea area, FindAreaOf(globals, connection, options));
  v1::DeleteMapAreaRequest request;
  request.set_name(area.name());
  request.set_etag(area.etag());
  ENFILADE_RETURN_IF_ERROR(connection.Call(&MapAreaStub::DeleteMapArea, request).status());
  if (globals.json) {
    PrintJson(std::cout, {{"deleted", area.name()}});
  } else {
    std::cout << "deleted \"" << area.display_name() << "\" (" << area.name() << ")\n";
  }
  return absl::OkStatus();
}

absl::Status ExportAreas(const Globals& globals, const AreaExportOptions& options) {
  v1::ExportMapAreasRequest request;
  request.set_format(AreaFormats().at(options.format));
  request.set_robot_type(options.robot_type);
  if (!options.at.empty()) {
    ENFILADE_ASSIGN_OR_RETURN(*request.mutable_time(), ParseTimeOption("--at", options.at));
  }
  const client::Connection connection = ConnectionOf(globals);
  ENFILADE_ASSIGN_OR_RETURN(const v1::Map map, FindMap(connection, globals, options.map));
  request.set_parent(map.name());
  ProgressBar bar(globals, "downloading", 0, "B");
  ENFILADE_ASSIGN_OR_RETURN(const auto files, client::ExportMapAreas(connection, request, options.directory,
                                                                     [&bar](std::int64_t done, std::int64_t total) {
                                                                       bar.SetTotal(total);
                                                                       bar.Update(done);
                                                                     }));
  bar.Finish();
  nlohmann::json document = {{"map", map.name()}, {"files", nlohmann::json::array()}};
  for (const std::filesystem::path& path : files) {
    document["files"].push_back(path.string());
    if (!globals.json) std::cout << path.string() << '\n';
  }
  if (globals.json) PrintJson(std::cout, document);
  return absl::OkStatus();
}

void AddAreaExport(CLI::App& area, const Globals& globals) {
  const auto options = std::make_shared<AreaExportOptions>();
  CLI::App* command = AddCommand(area, "export", "Write a map's areas as GeoJSON, or as a filter mask for Nav2",
                                 [&globals, options] { return ExportAreas(globals, *options); });
  command->add_option("MAP", options->map, "Its name, id or resource name")->required();
  command->add_option("-o,--output", options->directory, "The folder to write to")->required();
  std::vector<std::string> names;
  for (const auto& [name, format] : AreaFormats()) names.push_back(name);
  command
      ->add_option("--format", options->format,
                   "geojson (all areas), nav2-keepout (keepout.pgm and .yaml: keep-out and preferred areas) or "
                   "nav2-speed (speed.pgm and .yaml: speed limits)")
      ->check(CLI::IsMember(names))
      ->capture_default_str();
  command->add_option("--robot-type", options->robot_type, "Only areas that hold for this type of robot");
  command->add_option("--at", options->at,
                      "Only areas that hold then: 2026-01-31T08:00:00Z (default: now; of geojson: all)");
  command->footer(
      "Examples:\n  enfilade area export \"Main hall\" -o hall\n"
      "  enfilade area export \"Main hall\" -o hall --format nav2-keepout --robot-type forklift");
}

}  // namespace

void AddArea(CLI::App& app, const Globals& globals) {
  CLI::App* area = app.add_subcommand("area", "Areas of maps: keep-out, speed limits, rooms and others");
  area->require_subcommand(1);
  AddAreaEdit(*area, globals);
  const auto options = std::make_shared<AreaOptions>();
  const auto add = [&](const std::string& name, const std::string& description, auto run) {
    CLI::App* command =
        AddCommand(*area, name, description, [&globals, options, run] { return run(globals, *options); });
    command->add_option("MAP", options->map, "Its name, id or resource name")->required();
    return command;
  };
  add("list", "List a map's areas", ListAreas)->footer("Example: enfilade area list \"Main hall\"");
  CLI::App* show = add("show", "Show an area", ShowArea);
  show->add_option("AREA", options->area, "Its id, resource name or name")->required();
  show->footer("Example: enfilade area show \"Main hall\" Stairs");
  CLI::App* remove = add("delete", "Delete an area", DeleteArea);
  remove->add_option("AREA", options->area, "Its id, resource name or name")->required();
  remove->footer("Example: enfilade area delete \"Main hall\" Stairs");
  AddAreaExport(*area, globals);
}

}  // namespace enfilade::cli
