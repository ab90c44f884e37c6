// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <functional>
#include <vector>

#include "core/grid/occupancy_grid.h"
#include "core/prior/plan/plan_graph.h"

namespace enfilade::prior {

// Draws a wall between two points of the sheet.
inline void DrawWall(PlanGraph& plan, const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  const int first = static_cast<int>(plan.corners.size());
  plan.corners.push_back({from});
  plan.corners.push_back({to});
  plan.walls.push_back({.from = first, .to = first + 1});
}

// A building of 44 m x 24 m without any symmetry, at 20 units a metre: a corridor with rooms of different widths on
// both sides, a hall at one end.
inline PlanGraph DrawnBuilding() {
  PlanGraph plan;
  const auto wall = [&](double x0, double y0, double x1, double y1) {
    DrawWall(plan, 20 * Eigen::Vector2d(x0, y0), 20 * Eigen::Vector2d(x1, y1));
  };
  wall(0, 0, 44, 0), wall(44, 0, 44, 16), wall(44, 16, 34, 16), wall(34, 16, 34, 24), wall(34, 24, 0, 24),
      wall(0, 24, 0, 0);
  // The corridor, with a door into each room.
  const auto wall_with_doors = [&](double y, const std::vector<double>& doors, double from, double to) {
    for (const double door : doors) {
      wall(from, y, door, y);
      from = door + 1;
    }
    wall(from, y, to, y);
  };
  wall_with_doors(10, {2, 7.5, 13, 22, 30}, 0, 34);
  wall_with_doors(12.5, {4, 12, 19, 28}, 0, 34);
  for (const double x : {5.0, 12.0, 16.0, 26.0, 34.0}) wall(x, 0, x, 10);
  for (const double x : {8.0, 15.0, 24.0}) wall(x, 12.5, x, 24);
  wall(34, 12.5, 34, 16);
  wall(20, 4, 23, 4), wall(23, 4, 23, 6);
  return plan;
}

using Placement = std::function<Eigen::Vector2d(const Eigen::Vector2d&)>;  // sheet -> map, m

// What a robot maps of it at 0.05 m: walls, and free ground around those that `is_seen` (of points of the sheet).
inline grid::OccupancyGrid MapOf(const PlanGraph& plan, const Placement& place,
                                 const std::function<bool(const Eigen::Vector2d&)>& is_seen) {
  constexpr double kResolution = 0.05;
  Eigen::Vector2d min = Eigen::Vector2d::Constant(1e9);
  Eigen::Vector2d max = -min;
  for (const PlanCorner& corner : plan.corners) {
    min = min.cwiseMin(place(corner.point));
    max = max.cwiseMax(place(corner.point));
  }
  min.array() -= 2;
  max.array() += 2;
  grid::OccupancyGrid map;
  map.geometry.resolution = kResolution;
  map.geometry.T_map_grid = {min.x(), min.y(), 0};
  map.geometry.width = static_cast<int>((max.x() - min.x()) / kResolution);
  map.geometry.height = static_cast<int>((max.y() - min.y()) / kResolution);
  map.cells.assign(map.geometry.cell_count(), grid::kUnknownCell);
  const auto set = [&](const Eigen::Vector2d& point, double probability) {
    const Eigen::Vector2d cell = (point - min) / kResolution;
    const auto column = static_cast<int>(std::floor(cell.x()));
    const auto row = static_cast<int>(std::floor(cell.y()));
    if (map.geometry.contains(column, row))
      map.cells[map.geometry.index(column, row)] = grid::CellFromProbability(probability);
  };
  // Ground: the inside of the building, by its outline's two rectangles.
  const auto is_inside = [](const Eigen::Vector2d& p) {
    return p.x() > 0 && p.y() > 0 && p.x() < 880 && p.y() < 480 && (p.x() < 680 || p.y() < 320);
  };
  for (double y = 0; y < 480; y += 0.4) {
    for (double x = 0; x < 880; x += 0.4) {
      if (is_inside({x, y}) && is_seen({x, y})) set(place({x, y}), 0.05);
    }
  }
  for (const PlanWall& wall : plan.walls) {
    const Eigen::Vector2d from = plan.corners[static_cast<std::size_t>(wall.from)].point;
    const Eigen::Vector2d way = plan.corners[static_cast<std::size_t>(wall.to)].point - from;
    const int steps = static_cast<int>(way.norm() / 0.3) + 1;
    for (int i = 0; i <= steps; ++i) {
      const Eigen::Vector2d point = from + static_cast<double>(i) / steps * way;
      if (is_seen(point)) set(place(point), 0.95);
    }
  }
  return map;
}

}  // namespace enfilade::prior
