// SPDX-License-Identifier: Apache-2.0
// `enfilade map export` and `enfilade map import`.
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "client/cli/commands/commands.h"
#include "client/cli/map_file_import.h"
#include "client/cli/map_file_reader.h"
#include "client/cli/map_revision.h"
#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "client/sdk/api/map_export.h"
#include "client/sdk/api/maps.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace enfilade::cli {
namespace {

struct MapExportCommandOptions {
  std::string map;
  std::string revision;
  std::string directory = ".";
  std::string format = "pgm";
  bool without_edits = false;
};

absl::StatusOr<v1::MapFormat> MapFormatOf(const std::string& format) {
  if (format == "pgm") return v1::MAP_FORMAT_PGM;
  if (format == "png") return v1::MAP_FORMAT_PNG;
  if (format == "json") return v1::MAP_FORMAT_JSON;
  return InvalidArgument("format \"{}\": expected pgm, png or json", format);
}

absl::Status ExportMap(const Globals& globals, const MapExportCommandOptions& options) {
  const client::Connection connection = ConnectionOf(globals);
  v1::ExportMapRequest request;
  ENFILADE_ASSIGN_OR_RETURN(const v1::MapFormat format, MapFormatOf(options.format));
  request.set_format(format);
  if (options.map.starts_with("sites/") && options.map.find("/revisions/") != std::string::npos) {
    request.set_name(options.map);
  } else {
    ENFILADE_ASSIGN_OR_RETURN(const v1::Map map, FindMap(connection, globals, options.map));
    request.set_name(map.name());
    if (!options.revision.empty()) {
      ENFILADE_ASSIGN_OR_RETURN(*request.mutable_name(), RevisionNameOf(map, options.revision));
    }
  }
  request.set_without_edits(options.without_edits);
  ProgressBar bar(globals, "downloading", 0, "B");
  ENFILADE_ASSIGN_OR_RETURN(const client::ExportedMap exported,
                            client::ExportMap(connection, request, options.directory, ShownBy(bar)));
  bar.Finish();
  if (globals.json) {
    nlohmann::json document = RevisionToJson(exported.revision);
    document["bytes"] = exported.bytes;
    for (const std::filesystem::path& path : exported.files) document["files"].push_back(path.string());
    PrintJson(std::cout, document);
    return absl::OkStatus();
  }
  PrintRevision(exported.revision);
  for (const std::filesystem::path& path : exported.files) std::cout << path.string() << '\n';
  return absl::OkStatus();
}

struct MapImportCommandOptions {
  std::string file;
  std::string map;
  std::string dialect = "nav2";
  int level = 0;
  bool keep_edits = false;
};

absl::Status ImportMap(const Globals& globals, const MapImportCommandOptions& options) {
  if (options.dialect != "nav2" && options.dialect != "ros1") {
    return InvalidArgument("dialect \"{}\": expected nav2 or ros1", options.dialect);
  }
  ENFILADE_ASSIGN_OR_RETURN(std::vector<grid::MapFile> files, ReadMapFiles(options.file));
  return ImportMapFiles(globals, ConnectionOf(globals), std::move(files),
                        {.site = SiteId(globals.site),
                         .map = options.map,
                         .level = options.level,
                         .dialect = options.dialect == "ros1" ? v1::MAP_DIALECT_ROS1 : v1::MAP_DIALECT_NAV2,
                         .keep_edits = options.keep_edits});
}

}  // namespace

void AddMapExport(CLI::App& map, const Globals& globals) {
  auto options = std::make_shared<MapExportCommandOptions>();
  CLI::App* command = AddCommand(map, "export", "Write a map's newest revision, or the one named, as files",
                                 [&globals, options] { return ExportMap(globals, *options); });
  command->add_option("MAP", options->map, "The map's name, id or resource name, or a revision's resource name")
      ->required();
  command->add_option("--revision", options->revision, "The number of a revision, or an alias (default: the newest)");
  command->add_option("-o,--output", options->directory, "The folder to write to")->capture_default_str();
  command->add_option("--format", options->format, "pgm or png (each with a YAML for Nav2), or json")
      ->capture_default_str();
  command->add_flag("--without-edits", options->without_edits, "Only what robots have seen and what was imported");
  command->footer("Example: enfilade map export \"Main hall\" -o maps --format png");
}

void AddMapImport(CLI::App& map, const Globals& globals) {
  auto options = std::make_shared<MapImportCommandOptions>();
  CLI::App* command = AddCommand(map, "import", "Upload files as a map's newest revision",
                                 [&globals, options] { return ImportMap(globals, *options); });
  command->add_option("FILE", options->file, "A .yaml beside the PGM or PNG that it names, or a .json")->required();
  command->add_option("--map", options->map, "The map's name, id or resource name; created if missing")->required();
  command->add_option("--dialect", options->dialect, "Whose rules the thresholds follow: nav2 or ros1")
      ->capture_default_str();
  command->add_option("--level", options->level, "The floor, if the map is created")->capture_default_str();
  command->add_flag("--keep-edits", options->keep_edits, "Lay published edits over the files instead of ending them");
  command->footer("Example: enfilade map import hall.yaml --map \"Main hall\"");
}

}  // namespace enfilade::cli
