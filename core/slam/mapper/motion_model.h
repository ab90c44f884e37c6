// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "core/geometry/pose2.h"
#include "core/slam/slam_options.h"

namespace enfilade::slam {

// A way driven, and how long it took.
struct Step {
  Pose2 T_from_to;
  double seconds = 0.0;

  friend bool operator==(const Step&, const Step&) = default;
};

// The way from the scan before to this one, before this one is looked at.
struct PredictedMotion {
  Pose2 T_last_now;
  double sigma_translation = 0.0;  // m
  double sigma_yaw = 0.0;          // rad
  bool by_odometry = false;
};

// `T_odom_last` and `T_odom_now` where odometry is known at either scan; `step` is the one before, of no use where
// there was none; `seconds` have passed since the last scan. Without odometry the robot goes on as fast as it went, as
// far as the scans' times can be believed: up to twice as far, since times may be those of arrival, in bursts.
PredictedMotion PredictMotion(const std::optional<Pose2>& T_odom_last, const std::optional<Pose2>& T_odom_now,
                              const std::optional<Step>& step, double seconds, const MotionOptions& options);

// Of (x, y, yaw), with the same deviation along x and y.
Eigen::Matrix3d InformationOf(double sigma_translation, double sigma_yaw);

}  // namespace enfilade::slam
