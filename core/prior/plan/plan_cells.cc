// SPDX-License-Identifier: Apache-2.0
#include "core/prior/plan/plan_cells.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/base/error.h"
#include "core/grid/map_raster.h"
#include "core/prior/plan/planar.h"

namespace enfilade::prior {
namespace {

using Eigen::Vector2d;

constexpr double kMargin = 0.5;         // m around the plan
constexpr double kNarrowestRoom = 0.4;  // m

// In cells, from the grid's lower left corner.
Vector2d ToCells(const grid::GridGeometry& geometry, const Vector2d& point_map) {
  return (Inverse(geometry.T_map_grid) * point_map) / geometry.resolution;
}

// The rows or columns whose middles lie between two places, of those that exist.
struct Range {
  int first;
  int last;
};
Range MiddlesBetween(double low, double high, int size) {
  const double end = size - 1;
  return {static_cast<int>(std::clamp(std::ceil(low - 0.5), 0.0, end + 1)),
          static_cast<int>(std::clamp(std::floor(high - 0.5), -1.0, end))};
}

}  // namespace

void VisitInside(const std::vector<Vector2d>& outline_map, const grid::GridGeometry& geometry, CellVisitor visit) {
  if (outline_map.empty()) return;
  std::vector<Vector2d> outline;
  for (const Vector2d& corner : outline_map) outline.push_back(ToCells(geometry, corner));
  const auto [lowest, highest] = std::minmax_element(
      outline.begin(), outline.end(), [](const Vector2d& a, const Vector2d& b) { return a.y() < b.y(); });
  const Range rows = MiddlesBetween(lowest->y(), highest->y(), geometry.height);
  std::vector<double> crossings;
  for (int row = rows.first; row <= rows.last; ++row) {
    crossings.clear();
    const double y = row + 0.5;
    for (std::size_t i = 0; i < outline.size(); ++i) {
      const Vector2d& a = outline[i];
      const Vector2d& b = outline[(i + 1) % outline.size()];
      if ((a.y() <= y) == (b.y() <= y)) continue;
      crossings.push_back(a.x() + (y - a.y()) / (b.y() - a.y()) * (b.x() - a.x()));
    }
    std::sort(crossings.begin(), crossings.end());
    for (std::size_t i = 0; i + 1 < crossings.size(); i += 2) {
      const Range columns = MiddlesBetween(crossings[i], crossings[i + 1], geometry.width);
      for (int column = columns.first; column <= columns.last; ++column) visit(geometry.index(column, row));
    }
  }
}

void VisitLine(const Vector2d& a_map, const Vector2d& b_map, double thickness, const grid::GridGeometry& geometry,
               CellVisitor visit) {
  const Vector2d a = ToCells(geometry, a_map);
  const Vector2d b = ToCells(geometry, b_map);
  const double reach = std::max(thickness / geometry.resolution, M_SQRT2) / 2;
  const Vector2d low = a.cwiseMin(b).array() - reach;
  const Vector2d high = a.cwiseMax(b).array() + reach;
  const Range rows = MiddlesBetween(low.y(), high.y(), geometry.height);
  const Range columns = MiddlesBetween(low.x(), high.x(), geometry.width);
  const double squared = std::max(1e-9, (b - a).squaredNorm());
  for (int row = rows.first; row <= rows.last; ++row) {
    for (int column = columns.first; column <= columns.last; ++column) {
      const Vector2d centre(column + 0.5, row + 0.5);
      const double t = std::clamp((centre - a).dot(b - a) / squared, 0.0, 1.0);
      if ((centre - a - t * (b - a)).norm() <= reach) visit(geometry.index(column, row));
    }
  }
}

absl::StatusOr<grid::OccupancyGrid> RasterOf(const PlanGraph& plan, double resolution, double thickness) {
  if (!plan.metres_per_unit) return InvalidArgument("the plan has no scale");
  if (plan.walls.empty()) return InvalidArgument("the plan has no walls");
  const double scale = *plan.metres_per_unit;
  const auto to_map = [scale](const Vector2d& point) { return Vector2d(point.x() * scale, -point.y() * scale); };
  Vector2d low = to_map(plan.corners[static_cast<std::size_t>(plan.walls.front().from)].point);
  Vector2d high = low;
  for (const PlanCorner& corner : plan.corners) {
    low = low.cwiseMin(to_map(corner.point));
    high = high.cwiseMax(to_map(corner.point));
  }
  const Vector2d size = ((high - low).array() + 2 * kMargin) / resolution;
  if (!(size.x() * size.y() < static_cast<double>(grid::kMaxRasterCells))) {
    return InvalidArgument("the plan is {:.0f} x {:.0f} cells large", size.x(), size.y());
  }
  grid::OccupancyGrid raster;
  raster.geometry.resolution = resolution;
  raster.geometry.T_map_grid = {low.x() - kMargin, low.y() - kMargin, 0.0};
  raster.geometry.width = static_cast<int>(std::ceil(size.x()));
  raster.geometry.height = static_cast<int>(std::ceil(size.y()));
  raster.cells.assign(raster.geometry.cell_count(), grid::kUnknownCell);
  const std::vector<PlanRoom> rooms = plan.rooms.empty() ? FindRooms(plan, kNarrowestRoom / scale) : plan.rooms;
  for (const PlanRoom& room : rooms) {
    std::vector<Vector2d> outline;
    std::transform(room.outline.begin(), room.outline.end(), std::back_inserter(outline), to_map);
    VisitInside(outline, raster.geometry,
                [&](std::size_t cell) { raster.cells[cell] = grid::CellFromProbability(0.0); });
  }
  for (const PlanWall& wall : plan.walls) {
    VisitLine(to_map(plan.corners[static_cast<std::size_t>(wall.from)].point),
              to_map(plan.corners[static_cast<std::size_t>(wall.to)].point),
              wall.thickness > 0 ? wall.thickness * scale : thickness, raster.geometry,
              [&](std::size_t cell) { raster.cells[cell] = grid::CellFromProbability(1.0); });
  }
  // Some drawings have walls that go on behind doors.
  for (const PlanDoor& door : plan.doors) {
    const Vector2d from = to_map(door.from);
    const Vector2d to = to_map(door.to);
    const double length = (to - from).norm();
    if (length <= thickness) continue;
    const Vector2d jamb = (to - from) * (thickness / 2 / length);
    VisitLine(from + jamb, to - jamb, thickness, raster.geometry,
              [&](std::size_t cell) { raster.cells[cell] = grid::CellFromProbability(0.0); });
  }
  return raster;
}

}  // namespace enfilade::prior
