// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/geometry/pose2.h"
#include "core/grid/occupancy_grid.h"
#include "core/localization/localization_options.h"
#include "core/localization/searchable_map.h"

namespace enfilade::localization {

// The surface of a wall, in the map's frame.
struct SurfacePoint {
  Eigen::Vector2d point;  // m, the centre of an occupied cell beside free ground
  Eigen::Vector2d open;   // unit, towards that ground; zero: it lies on all sides
};

// An occupancy grid, ready to be fitted to another one. Immutable.
class AlignableMap {
 public:
  // `grid` on the lattice of its resolution (grid::ResampleToLattice).
  AlignableMap(const grid::OccupancyGrid& grid, const LocalizationOptions& options);

  const SearchableMap& searchable() const { return searchable_; }
  double resolution() const { return resolution_; }  // m
  const std::vector<SurfacePoint>& surfaces() const { return surfaces_; }
  // Every kGroundSpacing m: what has been seen free.
  const std::vector<Eigen::Vector2d>& ground() const { return ground_; }

  static constexpr double kGroundSpacing = 0.2;  // m

 private:
  double resolution_;
  SearchableMap searchable_;
  std::vector<SurfacePoint> surfaces_;
  std::vector<Eigen::Vector2d> ground_;
};

}  // namespace enfilade::localization
