// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "core/geometry/pose2.h"

namespace enfilade::slam {

// `information` of (x, y, yaw), possibly singular, after adding an independent error of `sigma` (m) and `yaw_sigma`
// (rad):
//   (information^-1 + diag(sigma^2, sigma^2, yaw_sigma^2))^-1.
// It stands for what scan matching does not model. Symmetric positive definite.
Eigen::Matrix3d WithFloor(const Eigen::Matrix3d& information, double sigma, double yaw_sigma);

// The information of the tie between two submaps if the robot was lost in between: next to none.
Eigen::Matrix3d LostTie();

// Converts the information Omega of a pose T_a_b from errors in (x, y, yaw) of frame a to errors in the measurement's
// frame, as pose-graph edges have it: R' Omega R with R the rotation by `yaw` of T_a_b.
Eigen::Matrix3d InMeasurementFrame(const Eigen::Matrix3d& information, double yaw);

// The largest standard deviation of the translation over all directions, m; infinite if a direction is unconstrained.
double WeakestDirection(const Eigen::Matrix3d& information);

}  // namespace enfilade::slam
