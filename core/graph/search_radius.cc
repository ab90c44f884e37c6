// SPDX-License-Identifier: Apache-2.0
#include "core/graph/search_radius.h"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace enfilade::graph {

ErrorEllipse ErrorEllipse95(const Eigen::Matrix3d& covariance) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver;
  solver.computeDirect(covariance.topLeftCorner<2, 2>());
  const auto semi_axis = [](double variance) { return std::sqrt(kChiSquared2Dof95 * std::max(variance, 0.0)); };
  const Eigen::Vector2d major = solver.eigenvectors().col(1);
  return {.semi_major_m = semi_axis(solver.eigenvalues()(1)),
          .semi_minor_m = semi_axis(solver.eigenvalues()(0)),
          .angle = std::atan2(major.y(), major.x())};
}

double SearchRadius(const Eigen::Matrix3d& covariance, const SearchRadiusOptions& options) {
  return options.base_m + options.factor * ErrorEllipse95(covariance).semi_major_m;
}

std::optional<double> MahalanobisDistance(const PoseWithCovariance& a, const PoseWithCovariance& b) {
  const Eigen::Vector2d d = b.pose.translation() - a.pose.translation();
  if (d.isZero(0.0)) return 0.0;
  const Eigen::Matrix2d S = (a.covariance + b.covariance).topLeftCorner<2, 2>();
  const double determinant = S.determinant();
  const double scale = S.cwiseAbs().maxCoeff();
  if (!(determinant > 1e-12 * scale * scale)) return std::nullopt;
  return std::sqrt(d.dot(S.inverse() * d));
}

double Bearing(const Pose2& T_frame_robot, const Eigen::Vector2d& position) {
  const Eigen::Vector2d d = position - T_frame_robot.translation();
  return WrapAngle(std::atan2(d.y(), d.x()) - T_frame_robot.yaw);
}

}  // namespace enfilade::graph
