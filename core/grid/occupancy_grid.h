// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/geometry/pose2.h"

namespace enfilade::grid {

// The pose and size of a raster. Cell (column 0, row 0) is at the lower left; its lower-left CORNER is the grid's
// origin, and rows count upwards along the grid's y axis (ROS nav_msgs/OccupancyGrid, `origin` in Nav2's YAML).
struct GridGeometry {
  double resolution = 0.05;  // m, the side of a cell
  Pose2 T_map_grid;          // the origin's pose in the map's frame
  int width = 0;             // columns
  int height = 0;            // rows

  std::size_t cell_count() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
  std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(column);
  }
  bool contains(int column, int row) const { return column >= 0 && column < width && row >= 0 && row < height; }

  friend bool operator==(const GridGeometry&, const GridGeometry&) = default;
};

// The probability of occupancy of each cell in one byte: 0 = unknown, 1..255 = (value - 1) / 254.
struct OccupancyGrid {
  GridGeometry geometry;
  std::vector<std::uint8_t> cells;  // row-major, geometry.cell_count()

  friend bool operator==(const OccupancyGrid&, const OccupancyGrid&) = default;
};

constexpr std::uint8_t kUnknownCell = 0;

// The value of a known cell (1..255, rounded to nearest) for a probability in [0, 1].
std::uint8_t CellFromProbability(double probability);
// Inverse of the above; `cell` must be known.
double ProbabilityOfCell(std::uint8_t cell);

}  // namespace enfilade::grid
