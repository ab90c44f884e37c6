// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "core/base/time.h"
#include "core/geometry/pose2.h"
#include "core/rooms/room_partition.h"
#include "core/sensor/record.h"
#include "core/slam/slam_map.h"
#include "core/survey/level_survey.h"

namespace enfilade::server {

// Where a robot was during its drive: by time, on the level.
using DriveTrajectory = std::vector<slam::StampedPose>;

// A door that a robot has gone through, as it saw it.
struct ReportedDoor {
  TimeNs passed = 0;                       // when the robot was in it
  TimeNs reported = 0;                     // some way behind it
  std::optional<Pose2> T_robot_door = {};  // from the robot at that time, facing through the door; unset: unknown
  double width = 0.0;                      // m; 0: unknown
};

// `T_odom_robot`: at report.time.
ReportedDoor ToReportedDoor(const sensor::DoorReport& report, const std::optional<Pose2>& T_odom_robot);

// Between the scans before and after; `trajectory` must not be empty.
Pose2 PoseAt(const DriveTrajectory& trajectory, TimeNs time);

// The line across the door, on the level; `trajectory` must not be empty. Where nothing else is known, or it ends
// long before the door was reported, it is where the robot went through. Unset if it ends before that: on the way from
// another level.
std::optional<rooms::PassageHint> PassageAt(const DriveTrajectory& trajectory, const ReportedDoor& door);

// Gives each visit its pose on the level; those whose scan the survey could not use are dropped. A session without any
// is where the one before it ended.
void PlaceVisits(const DriveTrajectory& trajectory, survey::Drive& drive);

}  // namespace enfilade::server
