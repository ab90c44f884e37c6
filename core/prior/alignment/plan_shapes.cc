// SPDX-License-Identifier: Apache-2.0
#include "core/prior/alignment/plan_shapes.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>

#include "core/prior/alignment/directions.h"

namespace enfilade::prior {
namespace {

constexpr double kStretch = 1.12;  // of an axis; the other one shrinks as much

// `stretches`: their `linear` is applied to the sheet before it is turned and scaled.
void AddTurns(const std::vector<WallFace>& faces_sheet, const MapEvidence& evidence, bool mirrored,
              const std::vector<PlanShape>& stretches, const std::vector<double>& scales,
              std::vector<PlanShape>& shapes) {
  for (const double turn : LikelyTurns(faces_sheet, evidence, mirrored)) {
    for (int quarter = 0; quarter < 4; ++quarter) {
      const Eigen::Rotation2Dd rotation(turn + quarter * 0.5 * M_PI);
      const Eigen::Matrix2d turned = rotation.toRotationMatrix() * Eigen::Vector2d(1, mirrored ? 1 : -1).asDiagonal();
      for (const PlanShape& stretch : stretches) {
        for (const double scale : scales) shapes.push_back({turned * scale * stretch.linear, stretch.model});
      }
    }
  }
}

}  // namespace

std::vector<PlanShape> ShapesToTry(const std::vector<WallFace>& faces_sheet, const MapEvidence& evidence,
                                   const std::vector<double>& scales, Stretch stretch) {
  std::vector<PlanShape> stretches;
  if (stretch == Stretch::kNone) {
    stretches.push_back({});
  } else {
    const Eigen::Matrix2d axes = Eigen::Rotation2Dd(MainDirection(faces_sheet)).toRotationMatrix();
    for (const double by : {kStretch, 1 / kStretch}) {
      stretches.push_back(
          {axes * Eigen::Vector2d(by, 1 / by).asDiagonal() * axes.transpose(), TransformModel::kAffine});
    }
  }
  std::vector<PlanShape> shapes;
  for (const bool mirrored : {false, true}) AddTurns(faces_sheet, evidence, mirrored, stretches, scales, shapes);
  return shapes;
}

std::vector<PlanShape> TurnsOf(const PlanTransform& known_shape, const std::vector<WallFace>& faces_sheet,
                               const MapEvidence& evidence, const std::vector<double>& scales) {
  const Eigen::Matrix2d squared = known_shape.linear.transpose() * known_shape.linear;
  const PlanShape stretch{Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(squared).operatorSqrt(),
                          IsSimilarity(known_shape) ? TransformModel::kSimilarity : TransformModel::kAffine};
  std::vector<PlanShape> shapes;
  AddTurns(faces_sheet, evidence, known_shape.mirrored(), {stretch}, scales, shapes);
  return shapes;
}

}  // namespace enfilade::prior
