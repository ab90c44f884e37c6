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

// Where a session's robot was in its map at any moment: the mapped scans' poses, carried to the moment by odometry.
class SessionTrack {
 public:
  // Both in any order. Odometry need only cover what is asked for.
  SessionTrack(std::vector<slam::StampedPose> trajectory, std::vector<sensor::Odometry> odometry,
               const DoorClosureOptions& options);

  // T_map_robot. The covariance is that of odometry's way from the nearest mapped scan alone; unset where nothing was
  // mapped within 10 s.
  std::optional<PoseWithCovariance> PoseAt(TimeNs time) const;
  // T_odom_robot; unset where there is no odometry within half a second.
  std::optional<Pose2> OdometryAt(TimeNs time) const;
  // T_map_x of what odometry's frame has at T_odom_x, seen at `time`. Without odometry the robot was at x then.
  std::optional<PoseWithCovariance> ToMap(const Pose2& T_odom_x, TimeNs time) const;
  // T_x_robot of the same x, seen at `seen`, and the robot at `time`. Both were matched to the same map: only the
  // errors of matching (match_sigma) and odometry's since lie between them, whatever the map's frame is away.
  std::optional<PoseWithCovariance> WayFrom(const Pose2& T_odom_x, TimeNs seen, TimeNs time) const;

 private:
  std::vector<slam::StampedPose> trajectory_;
  std::vector<sensor::Odometry> odometry_;
  double sigma_;
  double yaw_sigma_;
  Eigen::Vector3d match_variances_;
};

}  // namespace enfilade::closure
