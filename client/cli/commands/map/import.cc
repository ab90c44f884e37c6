// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "client/cli/commands/commands.h"
#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "client/import/building_import.h"
#include "client/import/map_manager_import.h"
#include "client/sources/imports/map_manager_database.h"
#include "core/base/status_macros.h"
#include "core/grid/files/map_files.h"
#include "core/prior/formats/building_plan.h"
#include "core/prior/plan/plan_cells.h"
#include "io/file.h"

namespace enfilade::cli {
namespace {

struct BuildingCommandOptions {
  std::string path;
  std::string prefix;
};

void PrintReport(const Globals& globals, const client::ImportReport& report) {
  if (globals.json) {
    nlohmann::json rows = nlohmann::json::array();
    for (const client::ImportLine& line : report.lines()) {
      rows.push_back({{"row", line.item},
                      {"outcome", client::ToString(line.outcome)},
                      {"name", line.name},
                      {"remark", line.remark}});
    }
    return PrintJson(std::cout, {{"taken", report.taken()}, {"refused", report.refused()}, {"rows", std::move(rows)}});
  }
  std::vector<std::vector<std::string>> rows;
  for (const client::ImportLine& line : report.lines()) {
    rows.push_back({line.item, client::ToString(line.outcome), line.name, line.remark});
  }
  PrintTable(std::cout, {"ROW", "OUTCOME", "NAME", "REMARK"}, rows);
  std::cout << report.taken() << " taken, " << report.refused() << " refused\n";
}

constexpr double kResolution = 0.05;     // m, of the cells of a level
constexpr double kWallThickness = 0.15;  // m; a building.yaml has none

absl::StatusOr<client::LevelDrawing> DrawLevel(const prior::Building& building, std::size_t level) {
  ENFILADE_ASSIGN_OR_RETURN(grid::OccupancyGrid raster,
                            prior::RasterOf(prior::PlanOfLevel(building, level), kResolution, kWallThickness));
  ENFILADE_ASSIGN_OR_RETURN(std::vector<grid::MapFile> files,
                            grid::RenderFiles({raster.geometry, grid::OccupancyCells{std::move(raster.cells)}},
                                              building.levels[level].name, {.format = grid::MapFileFormat::kPng}));
  client::LevelDrawing drawing;
  for (grid::MapFile& file : files) drawing.push_back({std::move(file.name), std::move(file.bytes)});
  return drawing;
}

// The walls of each level that has any. Where that fails, the building gets a remark.
std::vector<client::LevelDrawing> DrawLevels(prior::Building& building) {
  std::vector<client::LevelDrawing> drawings(building.levels.size());
  for (std::size_t i = 0; i < building.levels.size(); ++i) {
    const prior::BuildingLevel& level = building.levels[i];
    if (level.walls.empty()) continue;
    absl::StatusOr<client::LevelDrawing> drawing = DrawLevel(building, i);
    if (drawing.ok()) {
      drawings[i] = *std::move(drawing);
    } else {
      building.remarks.push_back({.item = "levels " + level.name,
                                  .why = "its walls are not drawn: " + std::string(drawing.status().message())});
    }
  }
  return drawings;
}

absl::Status ImportBuilding(const Globals& globals, const BuildingCommandOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(const std::string yaml, io::ReadFile(options.path));
  ENFILADE_ASSIGN_OR_RETURN(prior::Building building, prior::ParseBuilding(yaml));
  const std::string prefix = options.prefix.empty() && !building.name.empty() ? building.name + " " : options.prefix;
  const std::vector<client::LevelDrawing> drawings = DrawLevels(building);
  client::ImportReport report;
  absl::Status status =
      client::ImportBuilding(ConnectionOf(globals), SiteId(globals.site), building, prefix, drawings, report);
  PrintReport(globals, report);
  return status;
}

absl::Status ImportMapManager(const Globals& globals, const std::string& path) {
  ENFILADE_ASSIGN_OR_RETURN(const sources::MapManagerContent content, sources::ReadMapManagerDatabase(path));
  client::ImportReport report;
  absl::Status status = client::ImportMapManager(ConnectionOf(globals), SiteId(globals.site), content, report);
  PrintReport(globals, report);
  return status;
}

}  // namespace

void AddImport(CLI::App& app, const Globals& globals) {
  CLI::App* group = app.add_subcommand("import", "Import the maps of other programs");
  group->require_subcommand(1);
  const auto path = std::make_shared<std::string>();
  CLI::App* map_manager =
      AddCommand(*group, "mapmanager", "Import the maps, link points and candidates of a map_manager database",
                 [&globals, path] { return ImportMapManager(globals, *path); });
  map_manager->add_option("DATABASE", *path, "Its linkpoints.db, with the point clouds beside it")->required();
  map_manager->footer("Example: enfilade --site campus import mapmanager ~/maps/linkpoints.db");
  const auto options = std::make_shared<BuildingCommandOptions>();
  CLI::App* building = AddCommand(*group, "building", "Import the walls, doors and lifts of an Open-RMF building.yaml",
                                  [&globals, options] { return ImportBuilding(globals, *options); });
  building->add_option("FILE", options->path, "The traffic editor's building.yaml")->required();
  building->add_option("--prefix", options->prefix, "The maps' names start with it (default: the building's name)");
  building->footer("Example: enfilade --site campus import building hotel.building.yaml");
}

}  // namespace enfilade::cli
