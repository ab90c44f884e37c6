// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "core/geometry/pose2.h"

namespace enfilade::slam {

// `information` (of (x, y, yaw), perhaps singular) with an independent error of `sigma` (m) and `yaw_sigma` (rad)
// added: what the matching's own account of its precision leaves out. Symmetric positive definite.
Eigen::Matrix3d WithFloor(const Eigen::Matrix3d& information, double sigma, double yaw_sigma);

// The information about a pose T_a_b, whose error is additive in (x, y, yaw) of frame a, as that of an edge a -> b with
// measurement T_a_b, whose error is in the measurement's frame: R' Omega R.
Eigen::Matrix3d InMeasurementFrame(const Eigen::Matrix3d& information, double yaw);

// The standard deviation of the translation in the direction in which it is the largest, m; infinite where open.
double WeakestDirection(const Eigen::Matrix3d& information);

}  // namespace enfilade::slam
