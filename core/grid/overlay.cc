// SPDX-License-Identifier: Apache-2.0
#include "core/grid/overlay.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/grid/bresenham.h"
#include "core/grid/map_raster.h"

namespace enfilade::grid {
namespace {

constexpr double kMaxCoordinate = 1e9;  // cells, so that differences fit an int
constexpr int kEvenOdds = 128;          // a cell with equal odds
constexpr double kOffLattice = 1e-3;    // of a cell; allows for rounding

// Inclusive; empty if max is below min.
struct Box {
  CellIndex min;
  CellIndex max;
};

Box BoxOf(const OccupancyGrid& grid) {
  const GridGeometry& g = grid.geometry;
  const CellIndex min{static_cast<int>(std::lround(g.T_map_grid.x / g.resolution)),
                      static_cast<int>(std::lround(g.T_map_grid.y / g.resolution))};
  return {min, {min.column + g.width - 1, min.row + g.height - 1}};
}

Box Union(const Box& a, const Box& b) {
  return {{std::min(a.min.column, b.min.column), std::min(a.min.row, b.min.row)},
          {std::max(a.max.column, b.max.column), std::max(a.max.row, b.max.row)}};
}

absl::Status CheckSize(const Box& box) {
  const double width = static_cast<double>(box.max.column) - box.min.column + 1;
  const double height = static_cast<double>(box.max.row) - box.min.row + 1;
  if (width * height <= static_cast<double>(kMaxRasterCells)) return absl::OkStatus();
  return InvalidArgument("a grid of {} x {} cells is too large: {} at most", width, height, kMaxRasterCells);
}

OccupancyGrid Unknown(const Box& box, double resolution) {
  OccupancyGrid grid;
  grid.geometry.resolution = resolution;
  grid.geometry.T_map_grid = {box.min.column * resolution, box.min.row * resolution, 0.0};
  grid.geometry.width = box.max.column - box.min.column + 1;
  grid.geometry.height = box.max.row - box.min.row + 1;
  grid.cells.assign(grid.geometry.cell_count(), kUnknownCell);
  return grid;
}

bool IsOnLattice(const GridGeometry& geometry, double resolution) {
  const double column = geometry.T_map_grid.x / resolution;
  const double row = geometry.T_map_grid.y / resolution;
  return geometry.resolution == resolution && geometry.T_map_grid.yaw == 0.0 &&
         std::abs(column - std::round(column)) < kOffLattice && std::abs(row - std::round(row)) < kOffLattice;
}

// The lattice cells that the grid can touch.
absl::StatusOr<Box> LatticeBoxOf(const GridGeometry& geometry, double resolution) {
  const double width = geometry.width * geometry.resolution;
  const double height = geometry.height * geometry.resolution;
  Eigen::Vector2d low = geometry.T_map_grid.translation();
  Eigen::Vector2d high = low;
  for (const Eigen::Vector2d& corner :
       {Eigen::Vector2d(width, 0), Eigen::Vector2d(0, height), Eigen::Vector2d(width, height)}) {
    low = low.cwiseMin(geometry.T_map_grid * corner);
    high = high.cwiseMax(geometry.T_map_grid * corner);
  }
  const Eigen::Vector2d limit = Eigen::Vector2d::Constant(kMaxCoordinate * resolution);
  if (!((low.array() > -limit.array()).all() && (high.array() < limit.array()).all())) {
    return InvalidArgument("the grid is more than {} cells of {} m away from the map's origin", kMaxCoordinate,
                           resolution);
  }
  const auto cell = [&](double v) { return static_cast<int>(std::floor(v / resolution)); };
  return Box{{cell(low.x()), cell(low.y())}, {cell(high.x()), cell(high.y())}};
}

void SampleCentres(const OccupancyGrid& from, OccupancyGrid& to) {
  const Pose2 T_from_map = Inverse(from.geometry.T_map_grid);
  for (int row = 0; row < to.geometry.height; ++row) {
    for (int column = 0; column < to.geometry.width; ++column) {
      const Eigen::Vector2d centre(column + 0.5, row + 0.5);
      const Eigen::Vector2d p = T_from_map * (to.geometry.T_map_grid * (centre * to.geometry.resolution));
      const int c = static_cast<int>(std::floor(p.x() / from.geometry.resolution));
      const int r = static_cast<int>(std::floor(p.y() / from.geometry.resolution));
      if (from.geometry.contains(c, r)) {
        to.cells[to.geometry.index(column, row)] = from.cells[from.geometry.index(c, r)];
      }
    }
  }
}

void KeepOccupied(const OccupancyGrid& from, OccupancyGrid& to) {
  for (int row = 0; row < from.geometry.height; ++row) {
    for (int column = 0; column < from.geometry.width; ++column) {
      const std::uint8_t value = from.cells[from.geometry.index(column, row)];
      if (value <= kEvenOdds) continue;
      const Eigen::Vector2d centre(column + 0.5, row + 0.5);
      const Eigen::Vector2d p = from.geometry.T_map_grid * (centre * from.geometry.resolution);
      const Eigen::Vector2d q = (p - to.geometry.T_map_grid.translation()) / to.geometry.resolution;
      const int c = static_cast<int>(std::floor(q.x()));
      const int r = static_cast<int>(std::floor(q.y()));
      if (!to.geometry.contains(c, r)) continue;
      std::uint8_t& cell = to.cells[to.geometry.index(c, r)];
      cell = std::max(cell, value);
    }
  }
}

OccupancyGrid Cropped(const OccupancyGrid& grid) {
  Box known{{grid.geometry.width, grid.geometry.height}, {-1, -1}};
  for (int row = 0; row < grid.geometry.height; ++row) {
    for (int column = 0; column < grid.geometry.width; ++column) {
      if (grid.cells[grid.geometry.index(column, row)] == kUnknownCell) continue;
      known.min = {std::min(known.min.column, column), std::min(known.min.row, row)};
      known.max = {std::max(known.max.column, column), std::max(known.max.row, row)};
    }
  }
  OccupancyGrid result;
  result.geometry.resolution = grid.geometry.resolution;
  if (known.max.column < 0) return result;
  const CellIndex origin = BoxOf(grid).min;
  result = Unknown({{origin.column + known.min.column, origin.row + known.min.row},
                    {origin.column + known.max.column, origin.row + known.max.row}},
                   grid.geometry.resolution);
  for (int row = 0; row < result.geometry.height; ++row) {
    const auto begin =
        grid.cells.begin() + static_cast<std::ptrdiff_t>(grid.geometry.index(known.min.column, known.min.row + row));
    std::copy_n(begin, result.geometry.width,
                result.cells.begin() + static_cast<std::ptrdiff_t>(result.geometry.index(0, row)));
  }
  return result;
}

// Neither is unknown. Equal odds agree with both.
bool Agree(std::uint8_t under, std::uint8_t over) {
  const int a = under - kEvenOdds;
  const int b = over - kEvenOdds;
  return (a >= 0 && b >= 0) || (a <= 0 && b <= 0);
}

void OverlayOnto(OccupancyGrid& grid, const OccupancyGrid& layer) {
  if (layer.cells.empty()) return;
  const CellIndex offset = BoxOf(layer).min;
  const CellIndex origin = BoxOf(grid).min;
  for (int row = 0; row < layer.geometry.height; ++row) {
    const std::uint8_t* over = &layer.cells[layer.geometry.index(0, row)];
    std::uint8_t* cell = &grid.cells[grid.geometry.index(offset.column - origin.column, offset.row - origin.row + row)];
    for (const std::uint8_t* end = over + layer.geometry.width; over != end; ++over, ++cell) {
      if (*over != kUnknownCell) *cell = Overlay(*cell, *over);
    }
  }
}

// The same in a larger box.
OccupancyGrid Within(const Box& box, const OccupancyGrid& grid, double resolution) {
  OccupancyGrid result = Unknown(box, resolution);
  OverlayOnto(result, grid);
  return result;
}

}  // namespace

absl::StatusOr<OccupancyGrid> ResampleToLattice(const OccupancyGrid& grid, double resolution) {
  if (IsOnLattice(grid.geometry, resolution)) return Cropped(grid);
  if (grid.cells.empty()) {
    OccupancyGrid empty;
    empty.geometry.resolution = resolution;
    return empty;
  }
  ENFILADE_ASSIGN_OR_RETURN(const Box box, LatticeBoxOf(grid.geometry, resolution));
  ENFILADE_RETURN_IF_ERROR(CheckSize(box));
  OccupancyGrid result = Unknown(box, resolution);
  SampleCentres(grid, result);
  KeepOccupied(grid, result);
  return Cropped(result);
}

std::uint8_t Overlay(std::uint8_t under, std::uint8_t over) {
  if (under == kUnknownCell) return over;
  if (over == kUnknownCell) return under;
  return Agree(under, over) && std::abs(under - kEvenOdds) > std::abs(over - kEvenOdds) ? under : over;
}

absl::StatusOr<OccupancyGrid> Overlay(const OccupancyGrid& under, const OccupancyGrid& over) {
  const OccupancyGrid* const layers[] = {&under, &over};
  return OverlayAll(layers);
}

absl::StatusOr<OccupancyGrid> OverlayAll(std::span<const OccupancyGrid* const> layers) {
  std::optional<Box> box;
  double resolution = 0.0;
  for (const OccupancyGrid* layer : layers) {
    if (layer->cells.empty()) {
      if (!box) resolution = layer->geometry.resolution;
      continue;
    }
    resolution = layer->geometry.resolution;
    const Box own = BoxOf(*layer);
    box = box ? Union(*box, own) : own;
    ENFILADE_RETURN_IF_ERROR(CheckSize(*box));
  }
  OccupancyGrid grid;
  grid.geometry.resolution = resolution;
  if (!box) return grid;
  grid = Unknown(*box, resolution);
  for (const OccupancyGrid* layer : layers) OverlayOnto(grid, *layer);
  return grid;
}

absl::StatusOr<LayerRun> Extend(const LayerRun& run, const OccupancyGrid& over) {
  if (over.cells.empty()) return run;
  ENFILADE_ASSIGN_OR_RETURN(OccupancyGrid content, Overlay(run.content, over));
  const double resolution = content.geometry.resolution;
  const Box box = BoxOf(content);
  const OccupancyGrid before = Within(box, run.content, resolution);
  const OccupancyGrid added = Within(box, over, resolution);
  OccupancyGrid reset = Within(box, run.reset, resolution);
  for (std::size_t i = 0; i < reset.cells.size(); ++i) {
    const std::uint8_t under = before.cells[i];
    if (under == kUnknownCell || added.cells[i] == kUnknownCell || Agree(under, added.cells[i])) continue;
    reset.cells[i] = under > kEvenOdds ? kEvenOdds + 1 : kEvenOdds - 1;
  }
  return LayerRun{Cropped(reset), std::move(content)};
}

}  // namespace enfilade::grid
