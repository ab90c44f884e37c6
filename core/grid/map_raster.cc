// SPDX-License-Identifier: Apache-2.0
#include "core/grid/map_raster.h"

#include <array>
#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/grid/occupancy_values.h"

namespace enfilade::grid {
namespace {

absl::Status ExpectCount(std::string_view what, std::size_t count, const GridGeometry& geometry) {
  if (count == geometry.cell_count()) return absl::OkStatus();
  return InvalidArgument("the raster has {} {}, but {} x {} cells", count, what, geometry.width, geometry.height);
}

absl::Status ValidateCells(const OccupancyCells& cells, const GridGeometry& geometry) {
  return ExpectCount("values", cells.values.size(), geometry);
}

absl::Status ValidateCells(const GreyCells& cells, const GridGeometry& geometry) {
  ENFILADE_RETURN_IF_ERROR(ExpectCount("greys", cells.grey.size(), geometry));
  if (!cells.alpha.empty()) ENFILADE_RETURN_IF_ERROR(ExpectCount("alphas", cells.alpha.size(), geometry));
  if (cells.max_value < 1 || cells.max_value > 255) {
    return InvalidArgument("the raster's largest grey is {}: expected 1 to 255", cells.max_value);
  }
  const GreyInterpretation& by = cells.interpretation;
  if (!std::isfinite(by.occupied_thresh)) return InvalidArgument("occupied_thresh is {}", by.occupied_thresh);
  if (!std::isfinite(by.free_thresh)) return InvalidArgument("free_thresh is {}", by.free_thresh);
  return absl::OkStatus();
}

absl::Status ValidateCells(const UnitCells& cells, const GridGeometry& geometry) {
  return ExpectCount("values", cells.values.size(), geometry);
}

std::vector<std::uint8_t> OccupancyOf(const OccupancyCells& cells) { return cells.values; }

std::vector<std::uint8_t> OccupancyOf(const GreyCells& cells) {
  std::array<std::uint8_t, 256> cell_of{};
  const std::array<std::int8_t, 256> values = LoadedValues(cells.interpretation, cells.max_value);
  for (std::size_t level = 0; level < cell_of.size(); ++level) cell_of[level] = CellFromOccupancyValue(values[level]);
  std::vector<std::uint8_t> occupancy(cells.grey.size());
  for (std::size_t i = 0; i < occupancy.size(); ++i) occupancy[i] = cell_of[cells.grey[i]];
  for (std::size_t i = 0; i < cells.alpha.size(); ++i) {  // only PNG images have alpha, and their max_value is 255
    occupancy[i] = CellFromOccupancyValue(LoadedValue(cells.interpretation, cells.grey[i], cells.alpha[i]));
  }
  return occupancy;
}

std::vector<std::uint8_t> OccupancyOf(const UnitCells& cells) {
  std::vector<std::uint8_t> occupancy(cells.values.size());
  for (std::size_t i = 0; i < occupancy.size(); ++i) occupancy[i] = CellFromProbability(cells.values[i]);
  return occupancy;
}

}  // namespace

absl::Status Validate(const GridGeometry& geometry) {
  if (!(geometry.resolution > 0.0) || !std::isfinite(geometry.resolution)) {
    return InvalidArgument("resolution is {}: expected positive, finite metres", geometry.resolution);
  }
  const Pose2& origin = geometry.T_map_grid;
  if (!IsFinite(origin)) {
    return InvalidArgument("origin is [{}, {}, {}]: expected finite numbers", origin.x, origin.y, origin.yaw);
  }
  if (geometry.width <= 0 || geometry.height <= 0) {
    return InvalidArgument("the map is {} x {} cells: it has no cells", geometry.width, geometry.height);
  }
  if (geometry.width > kMaxRasterCells / geometry.height) {
    return InvalidArgument("the map is {} x {} cells: more than {} are not supported", geometry.width, geometry.height,
                           kMaxRasterCells);
  }
  return absl::OkStatus();
}

absl::Status Validate(const MapRaster& raster) {
  ENFILADE_RETURN_IF_ERROR(Validate(raster.geometry));
  return std::visit([&](const auto& cells) { return ValidateCells(cells, raster.geometry); }, raster.cells);
}

MapRaster FromOccupancyGrid(OccupancyGrid grid) { return {grid.geometry, OccupancyCells{std::move(grid.cells)}}; }

OccupancyGrid ToOccupancyGrid(const MapRaster& raster) {
  return {raster.geometry, std::visit([](const auto& cells) { return OccupancyOf(cells); }, raster.cells)};
}

}  // namespace enfilade::grid
