// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/geometry/pose2.h"
#include "core/sensor/laser_scan.h"

namespace enfilade::grid {

// One scan as rays in a grid's frame, m.
struct ScanRays {
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();
  std::vector<Eigen::Vector2d> hits;       // the space up to here is free, here is something
  std::vector<Eigen::Vector2d> free_ends;  // the space up to here is free, more is not known
};

struct ScanRayOptions {
  // A hit farther than this says only that the space up to here is free, m.
  double max_range = 30.0;
  // A beam without return says that the space up to here (and the scan's range_max) is free, m. Shorter than
  // max_range, since glass and black surfaces return nothing either; 0: such a beam says nothing.
  double no_return_range = 5.0;
};

// Beams that tell nothing (NaN, below range_min) are left out.
ScanRays RaysOf(const sensor::LaserScan& scan, const Pose2& T_grid_robot, const ScanRayOptions& options);

}  // namespace enfilade::grid
