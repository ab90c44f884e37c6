#include "core/slam/motion_model.h"

#include <cmath>

namespace enfilade {

PredictedMotion PredictMotion(const std::optional<Pose2>& T_odom_last, const std::optional<Pose2>& T_odom_now,
                              const std::optional<Pose2>& T_before_last, const MotionOptions& options) {
  PredictedMotion motion;
  if (T_odom_last && T_odom_now) {
    motion.T_last_now = Between(*T_odom_last, *T_odom_now);
    const double length = motion.T_last_now.translation().norm();
    const double turn = std::abs(motion.T_last_now.yaw);
    motion.sigma_translation =
        options.translation_floor + options.translation_per_metre * length + options.translation_per_radian * turn;
    motion.sigma_yaw = options.yaw_floor + options.yaw_per_metre * length + options.yaw_per_radian * turn;
    motion.by_odometry = length <= options.max_step;
    if (motion.by_odometry) return motion;
  }
  motion.T_last_now = T_before_last.value_or(Pose2{});
  motion.sigma_translation = options.free_translation;
  motion.sigma_yaw = options.free_yaw;
  return motion;
}

Eigen::Matrix3d InformationOf(double sigma_translation, double sigma_yaw) {
  const double t = 1.0 / (sigma_translation * sigma_translation);
  return Eigen::Vector3d(t, t, 1.0 / (sigma_yaw * sigma_yaw)).asDiagonal();
}

}  // namespace enfilade
