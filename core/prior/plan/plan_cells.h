// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "absl/functional/function_ref.h"
#include "absl/status/statusor.h"
#include "core/grid/occupancy_grid.h"
#include "core/prior/plan/plan_graph.h"

namespace enfilade::prior {

// Called with the index of a cell of the grid.
using CellVisitor = absl::FunctionRef<void(std::size_t cell)>;

// The cells whose centres lie inside an outline (even-odd rule), m in the map's frame.
void VisitInside(const std::vector<Eigen::Vector2d>& outline_map, const grid::GridGeometry& geometry,
                 CellVisitor visit);

// The cells whose centres lie within half of `thickness` of the line from a to b, m in the map's frame: at least so
// many that no hole is left.
void VisitLine(const Eigen::Vector2d& a_map, const Eigen::Vector2d& b_map, double thickness,
               const grid::GridGeometry& geometry, CellVisitor visit);

// A plan as an occupancy map: its rooms and doors are free, its walls occupied, everything else unknown. The map's
// frame is that of the sheet in metres with y up: a point (x, y) of the sheet is (x, -y) * metres_per_unit. Walls of
// unknown thickness are as thick as `thickness`, m. A plan without rooms gets those that its walls and doors enclose.
// INVALID_ARGUMENT: the plan has no scale or no walls, or needs more than grid::kMaxRasterCells.
absl::StatusOr<grid::OccupancyGrid> RasterOf(const PlanGraph& plan, double resolution, double thickness);

}  // namespace enfilade::prior
