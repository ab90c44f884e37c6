// SPDX-License-Identifier: Apache-2.0
#include "core/slam/matching/scan_matcher.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstddef>

namespace enfilade::slam {
namespace {

constexpr double kSmallStep = 5e-4;  // m
constexpr double kSmallTurn = 2e-4;  // rad
constexpr double kOnTheWall = 1e-5;  // m: nearer points have no gradient

double BeamWeight(std::size_t points, const FieldMatchOptions& options) {
  return std::min(1.0, options.effective_beams / static_cast<double>(points));
}

// Half the second derivatives of the squared distance: n n' at a wall with normal n, the identity at a corner or a
// post. Finite differences over 0.2 m, the depth of door frames and niches. Over shorter distances, a centimetre of
// noise in the hits would look like structure along the wall.
Eigen::Matrix2d WallStructure(const LikelihoodField& field, const Eigen::Vector2d& p) {
  constexpr double h = 0.2;  // m
  const auto f = [&](double x, double y) { return field.At({p.x() + h * x, p.y() + h * y}).squared_distance; };
  const double f0 = f(0, 0);
  Eigen::Matrix2d S;
  S(0, 0) = (f(1, 0) + f(-1, 0) - 2.0 * f0) / (2.0 * h * h);
  S(1, 1) = (f(0, 1) + f(0, -1) - 2.0 * f0) / (2.0 * h * h);
  S(0, 1) = S(1, 0) = (f(1, 1) + f(-1, -1) - f(1, -1) - f(-1, 1)) / (8.0 * h * h);
  return S;
}

Eigen::Matrix3d PositivePart(const Eigen::Matrix3d& M) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(M);
  return solver.eigenvectors() * solver.eigenvalues().cwiseMax(0.0).asDiagonal() * solver.eigenvectors().transpose();
}

// The information about the pose that the scan itself holds.
Eigen::Matrix3d ScanInformation(const LikelihoodField& field, const std::vector<Eigen::Vector2d>& points,
                                const Pose2& pose, const FieldMatchOptions& options) {
  const double width2 = options.kernel_width * options.kernel_width;
  const double inverse_sigma2 = 1.0 / (options.sigma * options.sigma);
  const double scale = BeamWeight(points.size(), options) * inverse_sigma2;
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector2d& p : points) {
    const Eigen::Vector2d q = pose * p;
    const double r2 = field.At(q).squared_distance * inverse_sigma2;
    Eigen::Matrix<double, 2, 3> G;
    G << 1.0, 0.0, pose.y - q.y(), 0.0, 1.0, q.x() - pose.x;
    information += scale / (1.0 + r2 / width2) * G.transpose() * WallStructure(field, q) * G;
  }
  return PositivePart(0.5 * (information + information.transpose()));
}

// The 68 % quantile of distances that are given squared.
double ResidualOf(std::vector<double>& squared_distances) {
  if (squared_distances.empty()) return 0.0;
  const auto quantile = squared_distances.begin() + static_cast<std::ptrdiff_t>(0.68 * squared_distances.size());
  std::nth_element(squared_distances.begin(), quantile, squared_distances.end());
  return std::sqrt(*quantile);
}

}  // namespace

MatchCost EvaluateMatch(const LikelihoodField& field, const std::vector<Eigen::Vector2d>& points, const Pose2& pose,
                        const PosePrior& prior, const FieldMatchOptions& options,
                        const std::vector<Eigen::Vector2d>& normals) {
  MatchCost cost;
  const double c = std::cos(pose.yaw);
  const double s = std::sin(pose.yaw);
  const double width2 = options.kernel_width * options.kernel_width;
  const double inverse_sigma2 = 1.0 / (options.sigma * options.sigma);
  const double beam_weight = BeamWeight(points.size(), options);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2d& p = points[i];
    const Eigen::Vector2d turned(c * p.x() - s * p.y(), s * p.x() + c * p.y());
    const LikelihoodField::Sample sample = field.At(turned + pose.translation());
    double d2 = sample.squared_distance;
    // Half the gradient of d^2 is d times the unit vector away from the wall, in which d^2 is a parabola.
    Eigen::Vector2d away = 0.5 * sample.gradient;
    double point_weight = beam_weight;
    if (!normals.empty() && !normals[i].isZero()) {
      const Eigen::Vector2d normal(c * normals[i].x() - s * normals[i].y(), s * normals[i].x() + c * normals[i].y());
      const double along = normal.dot(away);
      const double across2 = std::max(0.0, away.squaredNorm() - along * along);
      point_weight /= 1.0 + across2 * inverse_sigma2 / width2;
      d2 = std::max(0.0, d2 - across2);
      away = along * normal;
    }
    const double r2 = d2 * inverse_sigma2;
    cost.value += point_weight * width2 * std::log1p(r2 / width2);
    const double distance = away.norm();
    if (distance < kOnTheWall) continue;
    const double weight = point_weight * inverse_sigma2 / (1.0 + r2 / width2);
    const Eigen::Vector3d J =
        Eigen::Vector3d(away.x(), away.y(), away.y() * turned.x() - away.x() * turned.y()) / distance;
    cost.gradient += weight * distance * J;
    cost.hessian.noalias() += weight * J * J.transpose();
  }
  const Eigen::Vector3d off(pose.x - prior.pose.x, pose.y - prior.pose.y, WrapAngle(pose.yaw - prior.pose.yaw));
  cost.value += off.dot(prior.information * off);
  cost.gradient += prior.information * off;
  cost.hessian += prior.information;
  return cost;
}

MatchResult MatchToField(const LikelihoodField& field, const std::vector<Eigen::Vector2d>& points, const Pose2& guess,
                         const PosePrior& prior, const FieldMatchOptions& options,
                         const std::vector<Eigen::Vector2d>& normals) {
  MatchResult result;
  result.T_submap_robot = guess;
  if (points.empty()) return result;
  MatchCost cost = EvaluateMatch(field, points, guess, prior, options, normals);
  double damping = 1e-3;
  for (; result.iterations < options.max_iterations && !result.converged; ++result.iterations) {
    Eigen::Matrix3d damped = cost.hessian;
    damped.diagonal() += damping * cost.hessian.diagonal() + Eigen::Vector3d::Constant(1e-6);
    const Eigen::Vector3d step = -damped.ldlt().solve(cost.gradient);
    const Pose2 next{result.T_submap_robot.x + step.x(), result.T_submap_robot.y + step.y(),
                     WrapAngle(result.T_submap_robot.yaw + step.z())};
    const MatchCost next_cost = EvaluateMatch(field, points, next, prior, options, normals);
    if (next_cost.value < cost.value) {
      result.converged = step.head<2>().norm() < kSmallStep && std::abs(step.z()) < kSmallTurn;
      result.T_submap_robot = next;
      cost = next_cost;
      damping = std::max(1e-6, damping * 0.2);
    } else {
      result.converged = damping > 1e4 || (step.head<2>().norm() < kSmallStep && std::abs(step.z()) < kSmallTurn);
      damping *= 8.0;
    }
  }
  result.information = ScanInformation(field, points, result.T_submap_robot, options);
  std::vector<double> matched;  // m^2
  for (const Eigen::Vector2d& p : points) {
    const double d2 = field.At(result.T_submap_robot * p).squared_distance;
    if (d2 <= options.matched_distance * options.matched_distance) matched.push_back(d2);
  }
  result.matched_share = static_cast<double>(matched.size()) / static_cast<double>(points.size());
  result.residual = ResidualOf(matched);
  return result;
}

}  // namespace enfilade::slam
