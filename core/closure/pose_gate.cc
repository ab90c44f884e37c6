// SPDX-License-Identifier: Apache-2.0
#include "core/closure/pose_gate.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/graph/chi_squared.h"

namespace enfilade::closure {

double PoseChiSquared(const PoseWithCovariance& a, const PoseWithCovariance& b, double sigma, double yaw_sigma) {
  const Eigen::Vector3d e(b.pose.x - a.pose.x, b.pose.y - a.pose.y, WrapAngle(b.pose.yaw - a.pose.yaw));
  Eigen::Matrix3d S = a.covariance + b.covariance;
  S.diagonal() += Eigen::Vector3d(sigma * sigma, sigma * sigma, yaw_sigma * yaw_sigma);
  return e.dot(S.ldlt().solve(e));
}

PoseWithCovariance Turned(const PoseWithCovariance& T_map_place) {
  PoseWithCovariance turned = T_map_place;  // x and y are the map's axes: the covariance stays
  turned.pose.yaw = WrapAngle(turned.pose.yaw + M_PI);
  return turned;
}

double PlaceChiSquared(const PoseWithCovariance& a, const PoseWithCovariance& b, const DoorClosureOptions& options) {
  return std::min(PoseChiSquared(a, b, options.place_sigma, options.place_yaw_sigma),
                  PoseChiSquared(Turned(a), b, options.place_sigma, options.place_yaw_sigma));
}

double Gate(const DoorClosureOptions& options) { return graph::ChiSquaredQuantile(options.gate_probability, 3); }
double StrictGate(const DoorClosureOptions& options) {
  return graph::ChiSquaredQuantile(options.strict_probability, 3);
}

}  // namespace enfilade::closure
