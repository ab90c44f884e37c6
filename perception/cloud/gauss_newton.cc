// SPDX-License-Identifier: Apache-2.0
#include "perception/cloud/gauss_newton.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstddef>

namespace enfilade::perception {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

constexpr double kShrink = 0.85;      // of the correspondence distance, per step
constexpr double kStepMetres = 1e-4;  // smaller steps end the search
constexpr double kStepRadians = 1e-5;

struct CloudPair {
  const Surfels& source;
  const Surfels& target;
  const NearestPoints& target_tree;
};

struct NormalEquations {
  Matrix6d H = Matrix6d::Zero();
  Vector6d b = Vector6d::Zero();
  double residual = 0.0;
  int correspondences = 0;
};

Eigen::Matrix3d Skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d matrix;
  matrix << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return matrix;
}

// The pose is (t + v, Exp(w) R): the residual q - (Exp(w) R p + t + v) has the derivatives -1 by v, [R p]x by w.
NormalEquations Linearise(const CloudPair& clouds, const Eigen::Isometry3d& T, double distance,
                          RegistrationMethod method) {
  const auto& [source, target, tree] = clouds;
  NormalEquations equations;
  const Eigen::Matrix3d R = T.linear();
  const double squared_limit = distance * distance;
  const double width = squared_limit / 9.0;  // of the kernel
  for (std::size_t i = 0; i < source.points.size(); ++i) {
    const Eigen::Vector3d rotated = R * source.points[i].cast<double>();
    const Eigen::Vector3d moved = rotated + T.translation();
    const NearPoint near = tree.Nearest(moved.cast<float>());
    if (near.index < 0 || near.squared_distance > squared_limit) continue;
    const auto j = static_cast<std::size_t>(near.index);
    const Eigen::Vector3d r = target.points[j].cast<double>() - moved;
    Eigen::Matrix3d W = Eigen::Matrix3d::Identity();
    if (method == RegistrationMethod::kGicp) {
      W = (target.covariances[j] + R * source.covariances[i] * R.transpose()).inverse();
    }
    const double robust = width / (width + r.squaredNorm());
    W *= robust * robust;
    Eigen::Matrix<double, 3, 6> J;
    J << -Eigen::Matrix3d::Identity(), Skew(rotated);
    const Eigen::Matrix<double, 6, 3> JtW = J.transpose() * W;
    equations.H.noalias() += JtW * J;
    equations.b.noalias() += JtW * r;
    equations.residual += r.dot(W * r);
    ++equations.correspondences;
  }
  return equations;
}

// Damping keeps directions that the scene leaves unconstrained unchanged.
Vector6d Solve(const NormalEquations& equations) {
  Matrix6d H = equations.H;
  const double floor = 1e-6 * std::max(H.diagonal().maxCoeff(), 1e-9);
  H.diagonal().array() += floor;
  return -H.ldlt().solve(equations.b);
}

Eigen::Isometry3d Moved(const Eigen::Isometry3d& T, const Vector6d& step) {
  const Eigen::Vector3d w = step.tail<3>();
  Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
  const double angle = w.norm();
  const Eigen::Matrix3d turn =
      angle > 0.0 ? Eigen::AngleAxisd(angle, w / angle).toRotationMatrix() : Eigen::Matrix3d::Identity();
  result.linear() = Eigen::Quaterniond(turn * T.linear()).normalized().toRotationMatrix();
  result.translation() = T.translation() + step.head<3>();
  return result;
}

}  // namespace

Alignment Align(const Surfels& source, const Surfels& target, const NearestPoints& target_tree,
                const Eigen::Isometry3d& T_target_source_guess, const AlignOptions& options) {
  const CloudPair clouds{source, target, target_tree};
  Alignment alignment;
  alignment.T_target_source = T_target_source_guess;
  double distance = std::max(options.first_distance, options.last_distance);
  for (int i = 0; i < options.max_iterations; ++i) {
    const NormalEquations equations = Linearise(clouds, alignment.T_target_source, distance, options.method);
    alignment.iterations = i + 1;
    if (equations.correspondences < 6) break;
    const Vector6d step = Solve(equations);
    if (!step.allFinite()) break;
    alignment.T_target_source = Moved(alignment.T_target_source, step);
    if (distance <= options.last_distance && step.head<3>().norm() < kStepMetres &&
        step.tail<3>().norm() < kStepRadians) {
      alignment.converged = true;
      break;
    }
    distance = std::max(options.last_distance, kShrink * distance);
  }
  const NormalEquations last = Linearise(clouds, alignment.T_target_source, options.last_distance, options.method);
  alignment.correspondences = last.correspondences;
  alignment.weighted_residual = last.residual;
  alignment.normal = last.H;
  return alignment;
}

}  // namespace enfilade::perception
