// SPDX-License-Identifier: Apache-2.0
#include "core/geometry/pose2.h"

#include <cmath>

namespace enfilade {

double WrapAngle(double angle) {
  if (angle >= -M_PI && angle < M_PI) return angle;
  const double wrapped = angle - 2.0 * M_PI * std::floor((angle + M_PI) / (2.0 * M_PI));
  return wrapped >= M_PI ? wrapped - 2.0 * M_PI : wrapped;  // floor's rounding may leave exactly pi
}

Pose2 operator*(const Pose2& T_a_b, const Pose2& T_b_c) {
  const double c = std::cos(T_a_b.yaw);
  const double s = std::sin(T_a_b.yaw);
  return {T_a_b.x + c * T_b_c.x - s * T_b_c.y, T_a_b.y + s * T_b_c.x + c * T_b_c.y, WrapAngle(T_a_b.yaw + T_b_c.yaw)};
}

Eigen::Vector2d operator*(const Pose2& T_a_b, const Eigen::Vector2d& p_b) {
  const double c = std::cos(T_a_b.yaw);
  const double s = std::sin(T_a_b.yaw);
  return {T_a_b.x + c * p_b.x() - s * p_b.y(), T_a_b.y + s * p_b.x() + c * p_b.y()};
}

Pose2 Inverse(const Pose2& T_a_b) {
  const double c = std::cos(T_a_b.yaw);
  const double s = std::sin(T_a_b.yaw);
  return {-c * T_a_b.x - s * T_a_b.y, s * T_a_b.x - c * T_a_b.y, WrapAngle(-T_a_b.yaw)};
}

Pose2 Between(const Pose2& T_a_b, const Pose2& T_a_c) {
  const double c = std::cos(T_a_b.yaw);
  const double s = std::sin(T_a_b.yaw);
  const double dx = T_a_c.x - T_a_b.x;
  const double dy = T_a_c.y - T_a_b.y;
  return {c * dx + s * dy, -s * dx + c * dy, WrapAngle(T_a_c.yaw - T_a_b.yaw)};
}

Pose2 Interpolate(const Pose2& a, const Pose2& b, double t) {
  return {a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), WrapAngle(a.yaw + t * WrapAngle(b.yaw - a.yaw))};
}

bool IsFinite(const Pose2& pose) { return std::isfinite(pose.x) && std::isfinite(pose.y) && std::isfinite(pose.yaw); }

PoseWithCovariance Compose(const PoseWithCovariance& T_a_b, const PoseWithCovariance& T_b_c) {
  const double c = std::cos(T_a_b.pose.yaw);
  const double s = std::sin(T_a_b.pose.yaw);
  Eigen::Matrix3d J1 = Eigen::Matrix3d::Identity();
  J1(0, 2) = -s * T_b_c.pose.x - c * T_b_c.pose.y;
  J1(1, 2) = c * T_b_c.pose.x - s * T_b_c.pose.y;
  Eigen::Matrix3d J2 = Eigen::Matrix3d::Identity();
  J2.topLeftCorner<2, 2>() << c, -s, s, c;
  return {T_a_b.pose * T_b_c.pose, J1 * T_a_b.covariance * J1.transpose() + J2 * T_b_c.covariance * J2.transpose()};
}

PoseWithCovariance Inverse(const PoseWithCovariance& T_a_b) {
  const double c = std::cos(T_a_b.pose.yaw);
  const double s = std::sin(T_a_b.pose.yaw);
  const Pose2 inverse = Inverse(T_a_b.pose);
  Eigen::Matrix3d J;
  J << -c, -s, inverse.y, s, -c, -inverse.x, 0, 0, -1;
  return {inverse, J * T_a_b.covariance * J.transpose()};
}

}  // namespace enfilade
