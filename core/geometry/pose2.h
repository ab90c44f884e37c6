// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace enfilade {

// An element of SE(2): the pose of frame b in frame a, written T_a_b, in metres and radians. Composition reads
// T_a_c = T_a_b * T_b_c. The yaw of every result of the functions below is wrapped into [-pi, pi).
struct Pose2 {
  double x = 0.0;
  double y = 0.0;
  double yaw = 0.0;

  Eigen::Vector2d translation() const { return {x, y}; }
  friend bool operator==(const Pose2&, const Pose2&) = default;
};

constexpr double kDegree = M_PI / 180.0;  // rad

// `angle` modulo 2 pi, in [-pi, pi).
double WrapAngle(double angle);

Pose2 operator*(const Pose2& T_a_b, const Pose2& T_b_c);
// The point in frame a of a point given in frame b.
Eigen::Vector2d operator*(const Pose2& T_a_b, const Eigen::Vector2d& p_b);
Pose2 Inverse(const Pose2& T_a_b);
// T_a_b^-1 * T_a_c = T_b_c.
Pose2 Between(const Pose2& T_a_b, const Pose2& T_a_c);

// From `a` to `b` at the fraction `t` in [0, 1]: translation linear, yaw along the shorter arc.
Pose2 Interpolate(const Pose2& a, const Pose2& b, double t);

bool IsFinite(const Pose2& pose);

// A pose with its 3x3 covariance in (x, y, yaw) of that pose: m^2, m rad, rad^2.
struct PoseWithCovariance {
  Pose2 pose;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

// T_a_c with S = J1 S1 J1' + J2 S2 J2', the two estimates independent (Smith, Self, Cheeseman 1990: compounding).
PoseWithCovariance Compose(const PoseWithCovariance& T_a_b, const PoseWithCovariance& T_b_c);
// T_b_a with S = J S J' (Smith, Self, Cheeseman 1990: reversal).
PoseWithCovariance Inverse(const PoseWithCovariance& T_a_b);

}  // namespace enfilade
