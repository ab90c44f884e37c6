// SPDX-License-Identifier: Apache-2.0
#include "core/prior/alignment/refine.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/prior/alignment/agreement.h"

namespace enfilade::prior {
namespace {

constexpr std::size_t kFewestPairs = 12;
// Distortion costs: prior sigmas of the logarithms of both axes' ratio, and of the shear (rad).
constexpr double kAnisotropySigma = 0.1;
constexpr double kShearSigma = 0.03;

struct Pair {
  Eigen::Vector2d point_map;
  Eigen::Vector2d point_sheet;  // the nearest on a face
  Eigen::Vector2d normal;       // unit, of that face in the map's frame
  double weight;
};

// The small change of a transform: p -> centre + (1 + [growth, turn, stretch, shear]) (p - centre) + shift.
// Columns: shift x, shift y, turn, growth, stretch (x more, y less), shear; in axes `axes` of the sheet in the map.
struct Change {
  Eigen::Vector2d centre;
  Eigen::Matrix2d axes;
};

Eigen::Matrix<double, 6, 1> JacobianOf(const Change& change, const Eigen::Vector2d& point,
                                       const Eigen::Vector2d& normal) {
  const Eigen::Vector2d r = point - change.centre;
  const Eigen::Vector2d own = change.axes.transpose() * r;
  const Eigen::Vector2d stretch = change.axes * Eigen::Vector2d(own.x(), -own.y());
  const Eigen::Vector2d shear = change.axes * Eigen::Vector2d(own.y(), own.x());
  Eigen::Matrix<double, 6, 1> jacobian;
  jacobian << normal.x(), normal.y(), normal.dot(Eigen::Vector2d(-r.y(), r.x())), normal.dot(r), normal.dot(stretch),
      normal.dot(shear);
  return jacobian;
}

void Apply(const Change& change, const Eigen::VectorXd& step, PlanTransform& transform) {
  Eigen::Matrix2d stretch;
  stretch << step(4), step(5), step(5), -step(4);
  Eigen::Matrix2d matrix = change.axes * stretch * change.axes.transpose();
  matrix(0, 0) += 1 + step(3);
  matrix(1, 1) += 1 + step(3);
  matrix = Eigen::Rotation2Dd(step(2)) * matrix;
  transform.linear = matrix * transform.linear;
  transform.offset = matrix * (transform.offset - change.centre) + change.centre + step.head<2>();
}

// Log ratio of the axes, and the shear, which the priors hold near zero.
Eigen::Vector2d DistortionOf(const PlanTransform& transform) {
  const Eigen::Vector2d x = transform.linear.col(0);
  const Eigen::Vector2d y = transform.linear.col(1);
  const double shear = 0.5 * x.normalized().dot(y.normalized());
  return {0.5 * std::log(x.norm() / y.norm()), transform.mirrored() ? shear : -shear};
}

std::vector<Pair> PairsOf(const FaceIndex& index, const std::vector<WallFace>& faces_sheet, const MapEvidence& evidence,
                          std::size_t stride, double width) {
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < evidence.walls.size(); i += stride) {
    const WallPoint& wall = evidence.walls[i];
    const Eigen::Vector2d along = wall.straightness > kStraight ? wall.along : Eigen::Vector2d::Zero();
    const auto nearest = index.Nearest(wall.point, along, kParallel, wall.open);
    if (!nearest) continue;
    const Eigen::Vector2d normal(-nearest->along.y(), nearest->along.x());
    const double scaled = nearest->distance * nearest->distance / (width * width);
    const WallFace& face = faces_sheet[static_cast<std::size_t>(nearest->face)];
    pairs.push_back({.point_map = wall.point,
                     .point_sheet = face.from + nearest->fraction * (face.to - face.from),
                     .normal = normal,
                     .weight = wall.straightness / ((1 + scaled) * (1 + scaled))});
  }
  return pairs;
}

}  // namespace

PlanTransform Refine(const std::vector<WallFace>& faces_sheet, const MapEvidence& evidence, const PlanTransform& start,
                     const RefineOptions& options) {
  PlanTransform transform = start;
  const std::size_t stride = evidence.walls.size() / options.most_points + 1;
  const int size = FreedomOf(options.model);
  for (int round = 0; round < options.rounds; ++round) {
    const double progress = options.rounds > 1 ? static_cast<double>(round) / (options.rounds - 1) : 1.0;
    const double width = options.widest * std::pow(options.narrowest / options.widest, progress);
    const FaceIndex index(Transformed(faces_sheet, transform), 2.5 * width);
    const std::vector<Pair> pairs = PairsOf(index, faces_sheet, evidence, stride, width);
    if (pairs.size() < kFewestPairs) return start;

    Change change{Eigen::Vector2d::Zero(), Eigen::Matrix2d::Identity()};
    for (const Pair& pair : pairs) change.centre += pair.point_map / static_cast<double>(pairs.size());
    change.axes.col(0) = transform.linear.col(0).normalized();
    change.axes.col(1) = Eigen::Vector2d(-change.axes(1, 0), change.axes(0, 0));
    Eigen::MatrixXd normal_matrix = Eigen::MatrixXd::Zero(6, 6);
    Eigen::VectorXd right = Eigen::VectorXd::Zero(6);
    for (const Pair& pair : pairs) {
      const Eigen::Vector2d placed = transform(pair.point_sheet);
      const auto jacobian = JacobianOf(change, placed, pair.normal);
      const double residual = pair.normal.dot(pair.point_map - placed);
      normal_matrix += pair.weight * jacobian * jacobian.transpose();
      right += pair.weight * residual * jacobian;
    }
    // The priors; a pair's weight is 1 / m^2.
    const Eigen::Vector2d distortion = DistortionOf(transform);
    const double stretch = 1 / (kAnisotropySigma * kAnisotropySigma);
    const double shear = 1 / (kShearSigma * kShearSigma);
    normal_matrix(4, 4) += stretch;
    right(4) -= stretch * distortion(0);
    normal_matrix(5, 5) += shear;
    right(5) -= shear * distortion(1);
    normal_matrix.diagonal().array() += 1e-9;
    Eigen::VectorXd step = Eigen::VectorXd::Zero(6);
    step.head(size) = normal_matrix.topLeftCorner(size, size).ldlt().solve(right.head(size));
    if (!step.allFinite()) return start;
    // A step that large has left where it began.
    step(2) = std::clamp(step(2), -0.1, 0.1);
    step(3) = std::clamp(step(3), -0.1, 0.1);
    Apply(change, step, transform);
  }
  return transform;
}

}  // namespace enfilade::prior
