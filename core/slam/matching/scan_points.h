// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/geometry/pose2.h"
#include "core/grid/scan_rays.h"

namespace enfilade::slam {

// The scan's rays in the robot's frame, with coordinates rounded to single precision (ranges have no more), so that
// they are stored exactly in half the space.
grid::ScanRays RobotRays(const sensor::LaserScan& scan, const grid::ScanRayOptions& options);

// The same rays seen from another frame.
grid::ScanRays Transformed(const Pose2& T_target_source, const grid::ScanRays& rays);

// Every point that lies at least `spacing` (m) from the one kept before it: near walls, which beams strike densely, do
// not outweigh far ones.
std::vector<Eigen::Vector2d> Thinned(const std::vector<Eigen::Vector2d>& points, double spacing);

// Every n-th point, so that at most `count` are left.
std::vector<Eigen::Vector2d> Subsampled(const std::vector<Eigen::Vector2d>& points, std::size_t count);

}  // namespace enfilade::slam
