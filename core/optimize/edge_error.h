#pragma once

#include <Eigen/Core>

#include "core/geometry/pose2.h"

namespace enfilade {

// The SE(2) error of a relative measurement, in the measurement's frame (see PoseGraphEdge): m, m, rad.
Eigen::Vector3d EdgeError(const Pose2& T_world_from, const Pose2& T_world_to, const Pose2& T_from_to);

// The error and its derivatives by (x, y, yaw) of both poses.
struct LinearizedEdge {
  Eigen::Vector3d error;
  Eigen::Matrix3d J_from;
  Eigen::Matrix3d J_to;
};
LinearizedEdge LinearizeEdge(const Pose2& T_world_from, const Pose2& T_world_to, const Pose2& T_from_to);

}  // namespace enfilade
