// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "core/geometry/pose2.h"

namespace enfilade::graph {

// The 95 % quantile of chi-squared with two degrees of freedom.
constexpr double kChiSquared2Dof95 = 5.991;

struct SearchRadiusOptions {
  double base_m = 20.0;
  // Multiplies the larger semi-axis of the 95 % ellipse. 2: the whole axis, as in map_manager.
  double factor = 2.0;
};

// The 95 % ellipse of a position: semi-axes in m, the larger first, and the angle of the larger from the x axis, rad.
struct ErrorEllipse {
  double semi_major_m = 0.0;
  double semi_minor_m = 0.0;
  double angle = 0.0;
};
ErrorEllipse ErrorEllipse95(const Eigen::Matrix3d& covariance);

// The radius around an uncertain pose within which link points are considered, m: base + factor * sqrt(5.991
// lambda_max), with lambda_max the larger eigenvalue of the position's covariance.
double SearchRadius(const Eigen::Matrix3d& covariance, const SearchRadiusOptions& options = {});

// sqrt(d' (S_a + S_b)^-1 d) of two independent position estimates. 0 if the positions are equal, otherwise empty if
// S_a + S_b is singular.
std::optional<double> MahalanobisDistance(const PoseWithCovariance& a, const PoseWithCovariance& b);

// The direction of `position` from a robot at `T_frame_robot`: counter-clockwise from its x axis, rad in [-pi, pi).
double Bearing(const Pose2& T_frame_robot, const Eigen::Vector2d& position);

}  // namespace enfilade::graph
