// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "client/cli/commands/commands.h"
#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "client/import/building_import.h"
#include "client/import/map_manager_import.h"
#include "client/sources/imports/map_manager_database.h"
#include "core/base/status_macros.h"
#include "core/prior/formats/building_file.h"
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

absl::Status ImportBuilding(const Globals& globals, const BuildingCommandOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(const std::string yaml, io::ReadFile(options.path));
  ENFILADE_ASSIGN_OR_RETURN(const prior::Building building, prior::ParseBuilding(yaml));
  const std::string prefix = options.prefix.empty() && !building.name.empty() ? building.name + " " : options.prefix;
  client::ImportReport report;
  absl::Status status = client::ImportBuilding(ConnectionOf(globals), SiteId(globals.site), building, prefix, report);
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
  CLI::App* building = AddCommand(*group, "building", "Import the levels, doors and lifts of an Open-RMF building.yaml",
                                  [&globals, options] { return ImportBuilding(globals, *options); });
  building->add_option("FILE", options->path, "The traffic editor's building.yaml")->required();
  building->add_option("--prefix", options->prefix, "The maps' names start with it (default: the building's name)");
  building->footer("Example: enfilade --site campus import building hotel.building.yaml");
}

}  // namespace enfilade::cli
