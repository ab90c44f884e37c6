// SPDX-License-Identifier: Apache-2.0
#include "core/prior/alignment/plan_transform.h"

#include <Eigen/Geometry>
#include <cmath>

namespace enfilade::prior {

double PlanTransform::scale() const { return std::sqrt(std::abs(linear.determinant())); }

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
