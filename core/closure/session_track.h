// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "core/base/time.h"
#include "core/closure/closure_options.h"
#include "core/geometry/pose2.h"
#include "core/sensor/record.h"
#include "core/slam/slam_map.h"

namespace enfilade::closure {

// A session's robot in its map at any time: the pose of the mapped scan nearest in time, carried on by odometry.
class SessionTrack {
 public:
  // Both in any order. Odometry need only cover the times that are queried.
  SessionTrack(std::vector<slam::StampedPose> trajectory, std::vector<sensor::Odometry> odometry,
               const DoorClosureOptions& options);

  // T_map_robot, with the covariance of odometry since the nearest mapped scan only. Unset if no scan was mapped within
  // 10 s (1 s without odometry).
  std::optional<PoseWithCovariance> PoseAt(TimeNs time) const;
  // As PoseAt, but always: from the nearest mapped scan, or from `start` if there is none, by odometry as far as there
  // is any. What odometry does not show may be any way that a robot can drive in the time.
  PoseWithCovariance GuessPoseAt(TimeNs time, const slam::StampedPose& start) const;
  // T_odom_robot, interpolated between samples up to 1 s apart. Unset if no sample is within half a second.
  std::optional<Pose2> OdometryAt(TimeNs time) const;
  // T_map_x of a thing seen at `time`, whose pose in the odometry frame is T_odom_x. Without odometry it is taken to be
  // where the robot was.
  std::optional<PoseWithCovariance> ToMap(const Pose2& T_odom_x, TimeNs time) const;
  // T_x_robot of the same thing, seen at `seen`, and of the robot at `time`. Both were matched to the same map, so that
  // only the errors of matching (match_sigma) and of odometry since count, however far away the map's origin is.
  std::optional<PoseWithCovariance> RelativePose(const Pose2& T_odom_x, TimeNs seen, TimeNs time) const;

 private:
  std::vector<slam::StampedPose> trajectory_;
  std::vector<sensor::Odometry> odometry_;
  double sigma_;
  double yaw_sigma_;
  Eigen::Vector3d match_variances_;
};

}  // namespace enfilade::closure
