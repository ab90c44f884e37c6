// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "core/geometry/pose2.h"

namespace enfilade::localization {

// Where a robot was certain to be at one moment of its drive.
struct LocatedMoment {
  PoseWithCovariance T_map_robot;
  Pose2 T_odom_robot;
  double travelled = 0.0;  // m, since the drive's start
};

struct LocatedDriveOptions {
  // How far two moments may contradict each other by odometry: at once, and for each metre driven between them.
  double distance = 0.5;  // m
  double distance_per_metre = 0.1;
  double angle = 0.17;            // rad
  double angle_per_metre = 0.05;  // rad/m
  double one_is_enough = 10.0;    // m: of a drive that is no longer than this
};

// The first moment, if the drive's moments agree with each other: each with the next, by odometry. Unset if there are
// none, two contradict each other, or there is only one in a drive of `travelled` metres: of rooms that look alike, one
// alone may be known.
std::optional<LocatedMoment> FindStart(const std::vector<LocatedMoment>& moments, double travelled,
                                       const LocatedDriveOptions& options = {});

}  // namespace enfilade::localization
