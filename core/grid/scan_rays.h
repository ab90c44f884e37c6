// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/geometry/pose2.h"
#include "core/sensor/laser_scan.h"

namespace enfilade::grid {

// One scan as rays in a grid's frame, in m.
struct ScanRays {
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();
  std::vector<Eigen::Vector2d> hits;       // free up to here, occupied here
  std::vector<Eigen::Vector2d> free_ends;  // free up to here, unknown beyond
};

struct ScanRayOptions {
  // A hit farther away than this only marks the space up to this range as free, m.
  double max_range = 30.0;
  // A beam without return marks the space up to this range (at most the scan's range_max) as free, m. Shorter than
  // max_range because glass and black surfaces return nothing either. 0: such beams are ignored.
  double no_return_range = 5.0;
};

// Beams without information (NaN, below range_min) are skipped.
ScanRays RaysOf(const sensor::LaserScan& scan, const Pose2& T_grid_robot, const ScanRayOptions& options);

}  // namespace enfilade::grid
