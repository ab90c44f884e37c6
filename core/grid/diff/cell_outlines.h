// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/grid/bresenham.h"
#include "core/grid/diff/changed_runs.h"

namespace enfilade::grid {

// Corners of cells, the last one not repeated.
using CellRing = std::vector<CellIndex>;

// Cells that touch one another at sides.
struct CellPolygon {
  CellRing outer;               // counter-clockwise
  std::vector<CellRing> holes;  // clockwise
};

// The outlines of cells, along their sides. Cells that touch at a corner only are in polygons of their own, so that no
// ring crosses itself. `runs`: row by row, from the left.
std::vector<CellPolygon> OutlinesOf(const std::vector<ChangedRun>& runs);

}  // namespace enfilade::grid
