// SPDX-License-Identifier: Apache-2.0
#include "core/slam/loops/edge_information.h"

#include <Eigen/Dense>
#include <cmath>
#include <limits>

#include "core/slam/matching/motion_model.h"

namespace enfilade::slam {
namespace {

// Makes a singular matrix regular; negligible: standard deviations of about 30 m and 30 rad.
constexpr double kRegularisation = 1e-3;

// The robot may be anywhere near.
constexpr double kLostTranslation = 10.0;  // m
constexpr double kLostYaw = 3.0;           // rad

}  // namespace

Eigen::Matrix3d WithFloor(const Eigen::Matrix3d& information, double sigma, double yaw_sigma) {
  const Eigen::Matrix3d regular = information + kRegularisation * Eigen::Matrix3d::Identity();
  Eigen::Matrix3d covariance = regular.inverse();
  covariance.diagonal() += Eigen::Vector3d(sigma * sigma, sigma * sigma, yaw_sigma * yaw_sigma);
  const Eigen::Matrix3d result = covariance.inverse();
  return 0.5 * (result + result.transpose());
}

Eigen::Matrix3d LostTie() { return InformationOf(kLostTranslation, kLostYaw); }

Eigen::Matrix3d InMeasurementFrame(const Eigen::Matrix3d& information, double yaw) {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  R.topLeftCorner<2, 2>() << std::cos(yaw), -std::sin(yaw), std::sin(yaw), std::cos(yaw);
  const Eigen::Matrix3d turned = R.transpose() * information * R;
  return 0.5 * (turned + turned.transpose());
}

double WeakestDirection(const Eigen::Matrix3d& information) {
  const Eigen::Matrix3d regular = information + 1e-9 * Eigen::Matrix3d::Identity();
  const Eigen::Matrix2d covariance = regular.inverse().topLeftCorner<2, 2>();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(0.5 * (covariance + covariance.transpose()));
  const double largest = solver.eigenvalues()[1];
  return largest > 0.0 ? std::sqrt(largest) : std::numeric_limits<double>::infinity();
}

}  // namespace enfilade::slam
