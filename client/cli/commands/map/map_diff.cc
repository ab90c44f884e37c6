// SPDX-License-Identifier: Apache-2.0
// `enfilade map diff`.
#include "core/grid/diff/map_diff.h"

#include <array>
#include <filesystem>
#include <iostream>
#include <memory>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include "client/cli/commands/commands.h"
#include "client/cli/map_revision.h"
#include "client/cli/occupancy_map.h"
#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "enfilade/v1/map_service.grpc.pb.h"
#include "io/file.h"

namespace enfilade::cli {
namespace {

constexpr std::array<const char*, 3> kClassNames{"unknown", "free", "occupied"};

struct MapDiffCommandOptions {
  std::string base;
  std::string revision;
  std::string picture;
  std::string geojson;
  int regions = 20;
  std::optional<double> resolution;
};

struct ShownRegion {
  std::array<Eigen::Vector2d, 4> box;
  std::int64_t cells = 0;
  std::array<std::int64_t, 3> to{};
};

// From a server or from two files.
struct ShownDiff {
  std::string base;
  std::string revision;
  double resolution_m = 0.0;
  std::array<std::int64_t, 9> cells{};
  std::int64_t region_count = 0;
  std::vector<ShownRegion> regions;
  std::string picture;
  std::string geojson;

  std::int64_t changed_cells() const {
    return std::accumulate(cells.begin(), cells.end(), std::int64_t{0}) - cells[0] - cells[4] - cells[8];
  }
};

bool IsMapFile(const std::string& name) {
  const std::string extension = std::filesystem::path(name).extension().string();
  for (const char* known : {".yaml", ".yml", ".json", ".pgm", ".png"}) {
    if (extension == known) return true;
  }
  return false;
}

absl::StatusOr<ShownDiff> DiffFiles(const MapDiffCommandOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(grid::OccupancyGrid base, ReadOccupancyMap(options.base, options.resolution));
  ENFILADE_ASSIGN_OR_RETURN(grid::OccupancyGrid revision, ReadOccupancyMap(options.revision, options.resolution));
  ENFILADE_ASSIGN_OR_RETURN(
      const grid::MapDiff diff,
      grid::DiffRasters(grid::FromOccupancyGrid(std::move(base)), grid::FromOccupancyGrid(std::move(revision)),
                        {.max_regions = static_cast<std::size_t>(options.regions),
                         .with_picture = !options.picture.empty(),
                         .with_geojson = !options.geojson.empty()}));
  ShownDiff shown;
  shown.base = options.base;
  shown.revision = options.revision;
  shown.resolution_m = diff.resolution;
  shown.cells = diff.cells;
  shown.region_count = diff.region_count;
  for (const grid::MapDiffRegion& region : diff.regions) shown.regions.push_back({region.box, region.cells, region.to});
  if (diff.picture) {
    ENFILADE_ASSIGN_OR_RETURN(shown.picture, grid::EncodePng(diff.picture->image));
  }
  shown.geojson = diff.geojson;
  return shown;
}

absl::StatusOr<ShownDiff> DiffRevisions(const Globals& globals, const MapDiffCommandOptions& options) {
  const client::Connection connection = ConnectionOf(globals);
  // "@12" is a revision of the map of the base.
  const bool same_map = options.revision.starts_with('@');
  const std::string map = options.base.substr(0, options.base.rfind('@'));
  v1::DiffMapRevisionsRequest request;
  ENFILADE_ASSIGN_OR_RETURN(*request.mutable_base(), FindRevision(connection, globals, options.base));
  ENFILADE_ASSIGN_OR_RETURN(*request.mutable_revision(),
                            FindRevision(connection, globals, (same_map ? map : "") + options.revision));
  request.set_max_regions(options.regions);
  request.set_with_picture(!options.picture.empty());
  request.set_with_geojson(!options.geojson.empty());
  ENFILADE_ASSIGN_OR_RETURN(const v1::DiffMapRevisionsResponse response,
                            connection.Call(&v1::MapService::Stub::DiffMapRevisions, request));
  ShownDiff shown;
  shown.base = response.base();
  shown.revision = response.revision();
  shown.resolution_m = response.resolution_m();
  if (response.cells_size() == 9) std::copy(response.cells().begin(), response.cells().end(), shown.cells.begin());
  shown.region_count = response.region_count();
  for (const v1::MapDiffRegion& region : response.regions()) {
    ShownRegion& added = shown.regions.emplace_back();
    added.cells = region.cells();
    added.to = {region.to_unknown(), region.to_free(), region.to_occupied()};
    for (int i = 0; i < std::min(4, region.box().corners_size()); ++i) {
      added.box[static_cast<std::size_t>(i)] = {region.box().corners(i).x(), region.box().corners(i).y()};
    }
  }
  shown.picture = response.picture();
  shown.geojson = response.geojson();
  return shown;
}

nlohmann::json ToJson(const ShownDiff& diff) {
  nlohmann::json regions = nlohmann::json::array();
  for (const ShownRegion& region : diff.regions) {
    nlohmann::json box = nlohmann::json::array();
    for (const Eigen::Vector2d& corner : region.box) box.push_back({corner.x(), corner.y()});
    regions.push_back({{"cells", region.cells},
                       {"to_occupied", region.to[2]},
                       {"to_free", region.to[1]},
                       {"to_unknown", region.to[0]},
                       {"box", std::move(box)}});
  }
  nlohmann::json cells;
  for (std::size_t from = 0; from < 3; ++from) {
    for (std::size_t to = 0; to < 3; ++to) cells[kClassNames[from]][kClassNames[to]] = diff.cells[3 * from + to];
  }
  return {{"base", diff.base},
          {"revision", diff.revision},
          {"resolution_m", diff.resolution_m},
          {"cells", std::move(cells)},
          {"changed_cells", diff.changed_cells()},
          {"region_count", diff.region_count},
          {"regions", std::move(regions)}};
}

void PrintDiff(const ShownDiff& diff) {
  const double cell_m2 = diff.resolution_m * diff.resolution_m;
  std::cout << fmt::format("{} -> {}\n{} cells of {} m have changed ({:.2f} m2), in {} regions\n\n", diff.base,
                           diff.revision, diff.changed_cells(), diff.resolution_m,
                           static_cast<double>(diff.changed_cells()) * cell_m2, diff.region_count);
  std::vector<std::vector<std::string>> rows;
  for (std::size_t from = 0; from < 3; ++from) {
    rows.push_back({kClassNames[from]});
    for (std::size_t to = 0; to < 3; ++to) rows.back().push_back(std::to_string(diff.cells[3 * from + to]));
  }
  PrintTable(std::cout, {"FROM \\ TO", "UNKNOWN", "FREE", "OCCUPIED"}, rows);
  if (diff.regions.empty()) return;
  rows.clear();
  for (const ShownRegion& region : diff.regions) {
    const Eigen::Vector2d middle = 0.5 * (region.box[0] + region.box[2]);
    rows.push_back(
        {fmt::format("{:.2f} {:.2f}", middle.x(), middle.y()),
         fmt::format("{:.2f} x {:.2f}", (region.box[1] - region.box[0]).norm(), (region.box[3] - region.box[0]).norm()),
         std::to_string(region.cells), std::to_string(region.to[2]), std::to_string(region.to[1]),
         std::to_string(region.to[0])});
  }
  std::cout << '\n';
  PrintTable(std::cout, {"AT X Y", "SIZE M", "CELLS", "TO OCCUPIED", "TO FREE", "TO UNKNOWN"}, rows);
}

absl::Status DiffMaps(const Globals& globals, const MapDiffCommandOptions& options) {
  const bool are_files = IsMapFile(options.base);
  if (are_files != IsMapFile(options.revision)) {
    return InvalidArgument("{} and {}: expected two files, or two revisions of one map of the site", options.base,
                           options.revision);
  }
  if (!are_files && options.resolution) return InvalidArgument("--resolution is for files: revisions have their own");
  ENFILADE_ASSIGN_OR_RETURN(const ShownDiff diff, are_files ? DiffFiles(options) : DiffRevisions(globals, options));
  if (!options.picture.empty()) ENFILADE_RETURN_IF_ERROR(io::WriteFile(options.picture, diff.picture));
  if (!options.geojson.empty()) ENFILADE_RETURN_IF_ERROR(io::WriteFile(options.geojson, diff.geojson));
  if (globals.json) {
    nlohmann::json document = ToJson(diff);
    if (!options.picture.empty()) document["picture"] = options.picture;
    if (!options.geojson.empty()) document["geojson"] = options.geojson;
    PrintJson(std::cout, document);
    return absl::OkStatus();
  }
  PrintDiff(diff);
  for (const std::string& file : {options.picture, options.geojson}) {
    if (!file.empty()) std::cout << file << '\n';
  }
  return absl::OkStatus();
}

}  // namespace

void AddMapDiff(CLI::App& map, const Globals& globals) {
  const auto options = std::make_shared<MapDiffCommandOptions>();
  CLI::App* command = AddCommand(map, "diff", "Show what came and went between two revisions of a map, or two files",
                                 [&globals, options] { return DiffMaps(globals, *options); });
  command->add_option("A", options->base, "MAP, MAP@REVISION or MAP@ALIAS; or a file: .yaml, .json, .png, .pgm")
      ->required();
  command->add_option("B", options->revision, "The same; @REVISION or @ALIAS is of the map of A")->required();
  command->add_option("--plot", options->picture, "Write a PNG: what came is green, what went red");
  command->add_option("--geojson", options->geojson,
                      "Write outlines of what came and went, in metres of the map's frame");
  command->add_option("--regions", options->regions, "Of the regions that have changed, so many, the largest first")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command->add_option("--resolution", options->resolution, "Of files: metres per pixel, instead of what they say")
      ->check(CLI::PositiveNumber);
  command->footer(
      "Example: enfilade map diff \"Main hall@stable\" @12 --plot changes.png\n"
      "         enfilade map diff before.yaml after.yaml");
}

}  // namespace enfilade::cli
