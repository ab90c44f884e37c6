// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "core/grid/occupancy_grid.h"

namespace enfilade::areas {

// Which cells belong to an area.
enum class AreaCells {
  kInside,   // those whose centre is inside or on the edge, as in edits of maps
  kEntered,  // all that the area has a part of: one that is narrower than a cell has cells, too
};

// Cells of one row, from the first column to the last.
using VisitCells = std::function<void(int row, int first_column, int last_column)>;

// Visits the grid's cells that belong to a simple polygon; a cell may come more than once. `outline`: m, in the map's
// frame.
void RasterizeArea(const std::vector<Eigen::Vector2d>& outline, const grid::GridGeometry& geometry, AreaCells cells,
                   const VisitCells& visit);

}  // namespace enfilade::areas
