// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/closure/closure_options.h"
#include "core/geometry/pose2.h"
#include "core/sensor/laser_scan.h"

namespace enfilade::closure {

// A scan, and where it was taken.
struct PlacedScan {
  sensor::LaserScan scan;
  PoseWithCovariance T_map_robot;
};

// The hits of all scans that lie behind the door, in the frame of the robot at T_map_robot, m: what is seen back
// through the door belongs to the map before it. T_map_door looks the way that the robot has gone.
std::vector<Eigen::Vector2d> PointsBehind(const std::vector<PlacedScan>& scans, const Pose2& T_map_door,
                                          const Pose2& T_map_robot);

// The scans without the hits that lie beyond a door of the map, seen through it: they belong to the next map. A beam
// that crosses the door's plane within 1 m of its middle is as if it were not there, and so is a whole scan from within
// 0.5 m of the middle, which sees both sides. T_map_doors look either way through.
std::vector<PlacedScan> WithoutBeyond(std::vector<PlacedScan> scans, const std::vector<Pose2>& T_map_doors);

// Where in a map the robot is, by its scans.
struct ScanLocation {
  bool accepted = false;
  PoseWithCovariance T_map_robot;  // where accepted
  double matched_share = 0.0;      // of the points, on walls of the map
  std::string reason;
};

// Looks for `points` (the robot's frame) in what `known` scans have seen of a map, about the graph's prediction of the
// robot's pose there: an exhaustive search (SearchPose), refined and judged as SLAM judges a loop closure (MatchLoop).
// Accepted where most of the points lie on walls of the map and hardly any in its free space, the walls say where the
// robot is in all directions, nothing else in the window fits nearly as well, the pose passes the gate, and no
// look-alike can be meant: with e the prediction's error (95 %) and d the way from the prediction to the pose, the
// robot's true place is within e of the prediction, so that a look-alike of it, alike_distance away or more, is farther
// than alike_distance - e from the prediction; d must be less. Not looked for where e alone is more.
ScanLocation LocateByScans(const std::vector<PlacedScan>& known, const std::vector<Eigen::Vector2d>& points,
                           const PoseWithCovariance& predicted, const DoorClosureOptions& options);

}  // namespace enfilade::closure
