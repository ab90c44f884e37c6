// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/grid/distance_field.h"
#include "core/grid/occupancy_grid.h"
#include "core/rooms/room_options.h"

namespace enfilade::rooms {

enum class Ground : std::uint8_t {
  kUnknown = 0,
  kWall = 1,
  kOpen = 2,     // free, or an unseen spot between free cells
  kClutter = 3,  // a small obstacle that stands free: it bounds no room
};

// As std::lround, for values that an int can hold. Looking along lines calls it for each cell, and std::lround is a
// call.
inline int Rounded(double value) { return static_cast<int>(value + (value < 0.0 ? -0.5 : 0.5)); }

// What a map says about the ground. Cells and lengths are in cells, with (0, 0) the centre of the lower-left cell.
struct GroundMap {
  int width = 0;
  int height = 0;
  double resolution = 0.05;
  std::vector<Ground> cells;
  // For wall cells the extent of their group: the longer side of its bounding box, in cells. Walls are groups of one if
  // gaps of at most one cell part them.
  std::vector<std::uint16_t> extent;
  // For wall cells on a straight piece of wall its direction, 1..180 degrees from the columns' axis; 0: not straight.
  std::vector<std::uint8_t> direction;

  std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(column);
  }
  Eigen::Vector2d CentreOf(std::size_t cell) const {
    const auto columns = static_cast<std::size_t>(width);
    const std::size_t row = cell / columns;
    return {static_cast<double>(cell - row * columns), static_cast<double>(row)};
  }
  bool contains(int column, int row) const { return column >= 0 && column < width && row >= 0 && row < height; }
  Ground at(int column, int row) const { return contains(column, row) ? cells[index(column, row)] : Ground::kUnknown; }
  Ground at(const Eigen::Vector2d& cell) const { return at(Rounded(cell.x()), Rounded(cell.y())); }
  // Belongs to a room: neither wall nor unknown.
  bool IsOpen(int column, int row) const { return at(column, row) >= Ground::kOpen; }
  bool IsOpen(const Eigen::Vector2d& cell) const { return at(cell) >= Ground::kOpen; }
  bool IsOpen(std::size_t cell) const { return cells[cell] >= Ground::kOpen; }

  // Calls visit(index) for the cells at the sides of `cell`: left, right, below, above.
  template <typename Visit>
  void VisitSides(std::size_t cell, Visit&& visit) const {
    const auto columns = static_cast<std::size_t>(width);
    if (cell % columns > 0) visit(cell - 1);
    if (cell % columns + 1 < columns) visit(cell + 1);
    if (cell >= columns) visit(cell - columns);
    if (cell + columns < cells.size()) visit(cell + columns);
  }
};

GroundMap ReadGround(const grid::OccupancyGrid& grid, const RoomOptions& options,
                     std::span<const Eigen::Vector2d> trajectory);

using grid::DistanceField;

// To the nearest obstacle: wall or unknown; not clutter.
DistanceField DistancesToWalls(const GroundMap& ground);

// Between the map's frame, m, and cells.
Eigen::Vector2d ToCells(const grid::GridGeometry& geometry, const Eigen::Vector2d& p_map);
Eigen::Vector2d ToMap(const grid::GridGeometry& geometry, const Eigen::Vector2d& cells);

}  // namespace enfilade::rooms
