// SPDX-License-Identifier: Apache-2.0
#include "core/prior/localization/mode_in_map.h"

#include <Eigen/LU>
#include <cmath>

namespace enfilade::prior {

std::optional<PoseWithCovariance> InMap(const PlanField& field, const PlanMode& mode,
                                        const PlanTransform& T_map_sheet) {
  // From the plan frame: its y points up and the sheet's down.
  const Eigen::Matrix2d map_plan = T_map_sheet.linear * Eigen::Vector2d(1, -1).asDiagonal() / field.metres_per_unit();
  // From the robot's frame by way of the plan: a rotation, but for how the mode and the placement differ.
  const Eigen::Matrix2d turn = map_plan * LinearOf(mode.mean, field.axis());
  if (turn.determinant() <= 0) return std::nullopt;
  const Eigen::Vector2d at = T_map_sheet(field.ToSheet(mode.mean.translation()));
  PoseWithCovariance pose;
  pose.pose = {at.x(), at.y(), std::atan2(turn(1, 0) - turn(0, 1), turn(0, 0) + turn(1, 1))};
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  spread.topLeftCorner<2, 2>() = map_plan * MetresOf(mode.mean, field.axis()).inverse();
  spread(2, 2) = mode.mean.mirrored ? -1 : 1;
  pose.covariance = spread * mode.covariance.topLeftCorner<3, 3>() * spread.transpose();
  pose.covariance = (0.5 * (pose.covariance + pose.covariance.transpose())).eval();
  return pose;
}

}  // namespace enfilade::prior
