// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

#include "absl/status/statusor.h"

namespace enfilade::perception {

// Points in metres, in the frame of what they were taken from (the robot's, unless said otherwise). Scanners put NaN or
// infinities where nothing came back; every function here leaves such points out.
struct Cloud {
  std::vector<Eigen::Vector3f> points;
};

// A cloud of a full blob of float32 x y z has 5.6 million points.
constexpr std::size_t kMaxCloudPoints = 6'000'000;

// The points with three finite coordinates.
Cloud FinitePoints(const Cloud& cloud);

Cloud Transformed(const Cloud& cloud, const Eigen::Isometry3d& T_to_from);

// One point for each cube of side `voxel` (m) that holds any: their mean. Sorted by cube, so that the same points in
// another order give the same cloud up to rounding. INVALID_ARGUMENT: a voxel that is not positive, points further than
// a million voxels from the origin.
absl::StatusOr<Cloud> VoxelFilter(const Cloud& cloud, double voxel);

}  // namespace enfilade::perception
