// SPDX-License-Identifier: Apache-2.0
#include "core/areas/ignore_hits.h"

#include <array>

#include "core/areas/rasterize_area.h"
#include "core/grid/raster_pyramid.h"

namespace enfilade::areas {

void IgnoreHits(const std::vector<std::vector<Eigen::Vector2d>>& outlines, grid::OccupancyGrid& grid) {
  if (outlines.empty() || grid.cells.empty()) return;
  const std::array<grid::CellClass, 256> classes = grid::ClassesOfCells();
  for (const std::vector<Eigen::Vector2d>& outline : outlines) {
    RasterizeArea(outline, grid.geometry, AreaCells::kInside, [&](int row, int first_column, int last_column) {
      for (int column = first_column; column <= last_column; ++column) {
        std::uint8_t& cell = grid.cells[grid.geometry.index(column, row)];
        if (classes[cell] == grid::CellClass::kOccupied) cell = grid::kUnknownCell;
      }
    });
  }
}

}  // namespace enfilade::areas
