// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "core/geometry/pose2.h"
#include "core/slam/slam_options.h"

namespace enfilade::slam {

// A motion, and how long it took.
struct Step {
  Pose2 T_from_to;
  double seconds = 0.0;

  friend bool operator==(const Step&, const Step&) = default;
};

// The motion from the last scan to this one, predicted before this one is matched.
struct PredictedMotion {
  Pose2 T_last_now;
  double sigma_translation = 0.0;  // m
  double sigma_yaw = 0.0;          // rad
  bool by_odometry = false;
};

// `T_odom_last` and `T_odom_now`: odometry at the two scans, if known. `step`: the motion before, if any. `seconds`:
// time since the last scan. With odometry at both scans the prediction is its motion, with the standard deviations of
// MotionOptions. Without, or if odometry jumps farther than `max_step`, the velocity is taken to be constant, but the
// step is stretched to at most twice its length: times may be times of arrival, which come in bursts.
PredictedMotion PredictMotion(const std::optional<Pose2>& T_odom_last, const std::optional<Pose2>& T_odom_now,
                              const std::optional<Step>& step, double seconds, const MotionOptions& options);

// The information of (x, y, yaw) with the same standard deviation along x and y.
Eigen::Matrix3d InformationOf(double sigma_translation, double sigma_yaw);

}  // namespace enfilade::slam
