// SPDX-License-Identifier: Apache-2.0
#include "core/slam/matching/motion_model.h"

#include <algorithm>
#include <cmath>

namespace enfilade::slam {
namespace {

constexpr double kMaxStretch = 2.0;

Pose2 Scaled(const Pose2& step, double by) { return {by * step.x, by * step.y, by * step.yaw}; }

PredictedMotion ConstantVelocity(const std::optional<Step>& step, double seconds, const MotionOptions& options) {
  PredictedMotion motion;
  const double stretch = step && step->seconds > 0.0 ? std::clamp(seconds / step->seconds, 0.0, kMaxStretch) : 1.0;
  if (step) motion.T_last_now = Scaled(step->T_from_to, stretch);
  motion.sigma_translation = options.free_translation;
  motion.sigma_yaw = options.free_yaw;
  return motion;
}

}  // namespace

PredictedMotion PredictMotion(const std::optional<Pose2>& T_odom_last, const std::optional<Pose2>& T_odom_now,
                              const std::optional<Step>& step, double seconds, const MotionOptions& options) {
  if (T_odom_last && T_odom_now) {
    PredictedMotion motion;
    motion.T_last_now = Between(*T_odom_last, *T_odom_now);
    const double length = motion.T_last_now.translation().norm();
    const double turn = std::abs(motion.T_last_now.yaw);
    motion.sigma_translation =
        options.translation_floor + options.translation_per_metre * length + options.translation_per_radian * turn;
    motion.sigma_yaw = options.yaw_floor + options.yaw_per_metre * length + options.yaw_per_radian * turn;
    motion.by_odometry = length <= options.max_step;
    if (motion.by_odometry) return motion;
  }
  return ConstantVelocity(step, seconds, options);
}

Eigen::Matrix3d InformationOf(double sigma_translation, double sigma_yaw) {
  const double t = 1.0 / (sigma_translation * sigma_translation);
  return Eigen::Vector3d(t, t, 1.0 / (sigma_yaw * sigma_yaw)).asDiagonal();
}

}  // namespace enfilade::slam
