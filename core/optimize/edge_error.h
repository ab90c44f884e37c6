// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "core/geometry/pose2.h"

namespace enfilade::optimize {

// A relative measurement, and the part of its inverse that every evaluation needs.
struct EdgeMeasurement {
  EdgeMeasurement() = default;
  explicit EdgeMeasurement(const Pose2& measured);

  Pose2 T_from_to;
  Eigen::Vector2d translation_in_to = Eigen::Vector2d::Zero();  // R_m^T t_m
};

// The SE(2) error of the measurement, in its frame (see PoseGraphEdge): m, m, rad.
Eigen::Vector3d EdgeError(const Pose2& T_world_from, const Pose2& T_world_to, const EdgeMeasurement& measurement);

// The error with its derivatives with respect to (x, y, yaw) of both poses. The translation's error is
//   R(a)^T (t_to - t_from) - R_m^T t_m   with a = yaw_from + yaw_m,
// so that J_from = -J_to K, where K moves `to` rigidly with `from`.
struct LinearizedEdge {
  Eigen::Vector3d error;
  Eigen::Matrix3d J_to;  // [R(a)^T 0; 0 1]
  Eigen::Matrix3d K;     // [1 0 -(y_to - y_from); 0 1 x_to - x_from; 0 0 1]

  Eigen::Matrix3d J_from() const { return -J_to * K; }
};
LinearizedEdge LinearizeEdge(const Pose2& T_world_from, const Pose2& T_world_to, const EdgeMeasurement& measurement);

}  // namespace enfilade::optimize
