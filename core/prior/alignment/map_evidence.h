// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/geometry/pose2.h"
#include "core/grid/occupancy_grid.h"

namespace enfilade::prior {

// A place where a map has a wall.
struct WallPoint {
  Eigen::Vector2d point = Eigen::Vector2d::Zero();  // m, the map's frame
  Eigen::Vector2d along = Eigen::Vector2d::Zero();  // unit; the direction of the wall, either way
  // How straight the wall is around the point, 0 to 1: 1 - the ratio of the principal variances.
  double straightness = 0;
  // Unit, across the wall, to the side on which there is free ground; zero: on both, on none, or the wall is not
  // straight.
  Eigen::Vector2d open = Eigen::Vector2d::Zero();
};

enum class Ground : std::uint8_t { kUnknown, kFree, kWall };

// What a plan is compared with: the walls and the ground of an occupancy grid.
struct MapEvidence {
  std::vector<WallPoint> walls;  // about `spacing` apart, in the order of the grid's cells
  double spacing = 0.1;          // m
  grid::GridGeometry geometry;   // of `ground`
  Eigen::Isometry2d T_grid_map = Eigen::Isometry2d::Identity();  // the inverse of geometry.T_map_grid
  std::vector<Ground> ground;
  std::vector<float> wall_distance;  // m, to the nearest wall's cell, of each cell; at most kMostDistance

  // Of the grid; none outside.
  std::optional<std::size_t> CellOf(const Eigen::Vector2d& point) const;
  Ground GroundAt(const Eigen::Vector2d& point) const;
  // kMostDistance outside the grid.
  double WallDistanceAt(const Eigen::Vector2d& point) const;
  double wall_length() const { return spacing * static_cast<double>(walls.size()); }  // m
};

constexpr float kMostDistance = 5.0F;  // m

// Cells that are probably occupied are walls; where free ground is known, only those beside it. Some pictures have no
// unknown cells: there, only ground that walls enclose, up to gaps of a door's width, counts as free.
MapEvidence EvidenceOf(const grid::OccupancyGrid& grid);

}  // namespace enfilade::prior
