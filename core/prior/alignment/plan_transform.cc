// SPDX-License-Identifier: Apache-2.0
#include "core/prior/alignment/plan_transform.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>

namespace enfilade::prior {

double PlanTransform::scale() const { return std::sqrt(std::abs(linear.determinant())); }

bool IsSimilarity(const PlanTransform& transform) {
  const Eigen::Matrix2d squared = transform.linear.transpose() * transform.linear;
  const double scale = 0.5 * squared.trace();
  return (squared - scale * Eigen::Matrix2d::Identity()).norm() <= 1e-6 * scale;
}

PlanTransform AsSimilarity(const PlanTransform& T_map_sheet, const Eigen::Vector2d& fixed_map) {
  const Eigen::Matrix2d& linear = T_map_sheet.linear;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> squared(linear.transpose() * linear);
  const Eigen::Matrix2d turned = T_map_sheet.scale() * linear * squared.operatorInverseSqrt();
  return {turned, fixed_map - turned * ToSheet(T_map_sheet, fixed_map)};
}

Eigen::Vector2d ToSheet(const PlanTransform& T_map_sheet, const Eigen::Vector2d& point_map) {
  return T_map_sheet.linear.inverse() * (point_map - T_map_sheet.offset);
}

PlanTransform operator*(const Pose2& T_other_map, const PlanTransform& T_map_sheet) {
  const Eigen::Matrix2d rotation = Eigen::Rotation2Dd(T_other_map.yaw).toRotationMatrix();
  return {rotation * T_map_sheet.linear, T_other_map * T_map_sheet.offset};
}

std::string_view NameOf(TransformModel model) {
  switch (model) {
    case TransformModel::kRigid:
      return "rigid";
    case TransformModel::kSimilarity:
      return "similarity";
    case TransformModel::kAnisotropic:
      return "anisotropic";
    case TransformModel::kAffine:
      return "affine";
  }
  return "";
}

int FreedomOf(TransformModel model) {
  switch (model) {
    case TransformModel::kRigid:
      return 3;
    case TransformModel::kSimilarity:
      return 4;
    case TransformModel::kAnisotropic:
      return 5;
    case TransformModel::kAffine:
      return 6;
  }
  return 0;
}

}  // namespace enfilade::prior
