// SPDX-License-Identifier: Apache-2.0
#include "core/prior/localization/plan_state.h"

#include <Eigen/Geometry>
#include <cmath>

namespace enfilade::prior {
namespace {

// U diag(e^a, e^b) U' with the axes U.
Eigen::Matrix2d AlongAxes(double axis, double a, double b) {
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(axis).toRotationMatrix();
  return turn * Eigen::Vector2d(std::exp(a), std::exp(b)).asDiagonal() * turn.transpose();
}

}  // namespace

Eigen::Matrix2d LinearOf(const PlanState& state, double axis) {
  Eigen::Matrix2d turn = Eigen::Rotation2Dd(state.yaw).toRotationMatrix();
  if (state.mirrored) turn.col(1) = -turn.col(1);
  return AlongAxes(axis, -state.log_scale - state.log_stretch, -state.log_scale + state.log_stretch) * turn;
}

Eigen::Matrix2d MetresOf(const PlanState& state, double axis) {
  return AlongAxes(axis, state.log_scale + state.log_stretch, state.log_scale - state.log_stretch);
}

PlanState Moved(const PlanState& state, const Pose2& motion, double axis) {
  PlanState moved = state;
  const Eigen::Vector2d way = LinearOf(state, axis) * motion.translation();
  moved.x += way.x();
  moved.y += way.y();
  moved.yaw = WrapAngle(state.yaw + (state.mirrored ? -motion.yaw : motion.yaw));
  return moved;
}

}  // namespace enfilade::prior
