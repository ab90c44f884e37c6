// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

#include "absl/status/statusor.h"

namespace enfilade::perception {

// Points in metres, in the sensor platform's frame (the robot's, unless stated otherwise). Scanners mark missing
// returns by NaN or infinities; every function here ignores such points.
struct Cloud {
  std::vector<Eigen::Vector3f> points;
};

// The largest blob holds 5.6 million points of float32 x y z.
constexpr std::size_t kMaxCloudPoints = 6'000'000;

// The points with three finite coordinates.
Cloud FinitePoints(const Cloud& cloud);

Cloud Transformed(const Cloud& cloud, const Eigen::Isometry3d& T_to_from);

// The mean of the points in each occupied cube of side `voxel` (m). Sorted by cube, so that the order of the points
// changes nothing but rounding. INVALID_ARGUMENT: a voxel that is not positive, points more than a million voxels from
// the origin.
absl::StatusOr<Cloud> VoxelFilter(const Cloud& cloud, double voxel);

}  // namespace enfilade::perception
