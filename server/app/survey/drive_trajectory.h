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
  TimeNs time = 0;          // when the robot was at T_robot_door of it
  Pose2 T_robot_door = {};  // facing through the door
  double width = 0.0;       // m; 0: unknown
};

// `T_odom_robot`: at report.time. Without it the door is where the robot was on its way through.
ReportedDoor ToReportedDoor(const sensor::DoorReport& report, const std::optional<Pose2>& T_odom_robot);

// Between the scans before and after; `trajectory` must not be empty.
Pose2 PoseAt(const DriveTrajectory& trajectory, TimeNs time);

// The line across the door, on the level.
rooms::PassageHint PassageAt(const DriveTrajectory& trajectory, const ReportedDoor& door);

// Gives each visit its pose on the level; those whose scan the survey could not use are dropped. A session without any
// is where the one before it ended.
void PlaceVisits(const DriveTrajectory& trajectory, survey::Drive& drive);

}  // namespace enfilade::server
