// SPDX-License-Identifier: Apache-2.0
#include "client/cli/occupancy_map.h"

#include <string>
#include <utility>
#include <vector>

#include "client/cli/map_file_reader.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/grid/files/map_files.h"
#include "core/grid/files/plan_image.h"
#include "core/grid/map_raster.h"
#include "io/file.h"

namespace enfilade::cli {

absl::StatusOr<grid::OccupancyGrid> ReadOccupancyMap(const std::filesystem::path& path,
                                                     std::optional<double> resolution) {
  const std::string extension = path.extension().string();
  grid::OccupancyGrid grid;
  if (extension == ".yaml" || extension == ".yml" || extension == ".json") {
    ENFILADE_ASSIGN_OR_RETURN(const std::vector<grid::MapFile> files, ReadMapFiles(path));
    ENFILADE_ASSIGN_OR_RETURN(const grid::ImportedMap map, grid::ImportFiles(files, grid::MapDialect::kNav2));
    grid = grid::ToOccupancyGrid(map.raster);
  } else {
    ENFILADE_ASSIGN_OR_RETURN(const std::string bytes, io::ReadFile(path));
    absl::StatusOr<grid::OccupancyGrid> plan = grid::ReadPlan(bytes);
    if (!plan.ok()) return WithContext(plan.status(), path.string());
    grid = *std::move(plan);
  }
  if (resolution) grid.geometry.resolution = *resolution;
  const absl::Status valid = grid::Validate(grid.geometry);
  if (!valid.ok()) return WithContext(valid, path.string());
  return grid;
}

}  // namespace enfilade::cli
