// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

#include "core/closure/closure_options.h"
#include "core/geometry/pose2.h"
#include "core/sensor/laser_scan.h"
#include "core/slam/matching/field_pyramid.h"

namespace enfilade::closure {

// A scan, and the pose that it was taken from.
struct PlacedScan {
  sensor::LaserScan scan;
  PoseWithCovariance T_map_robot;
};

// The hits of all scans that lie behind the door, in the frame of the robot at T_map_robot, m. Hits that are seen back
// through the door belong to the map before it. T_map_door looks in the direction in which the robot passed.
std::vector<Eigen::Vector2d> PointsBehindDoor(const std::vector<PlacedScan>& scans, const Pose2& T_map_door,
                                              const Pose2& T_map_robot);

// The scans without the hits that were seen through a door of the map: they belong to the next map. A beam that crosses
// the door's plane within 1 m of its middle becomes unknown (NaN), and a scan taken within 0.5 m of the middle, which
// sees both sides, is left out. T_map_doors may look in either direction.
std::vector<PlacedScan> RemoveHitsThroughDoors(std::vector<PlacedScan> scans, const std::vector<Pose2>& T_map_doors);

// What scans have seen of a map, ready to be searched: some 2 MB for a room, and tens of milliseconds to make.
struct SeenGround {
  std::vector<PoseWithCovariance> viewpoints;  // T_map_robot of the scans
  slam::SearchableSubmap submap;               // in the map's frame

  explicit SeenGround(const std::vector<PlacedScan>& scans);

  // Bytes of memory held.
  std::size_t bytes() const;
};

// The robot's pose in a map, by its scans.
struct ScanLocation {
  bool accepted = false;
  PoseWithCovariance T_map_robot = {};  // if accepted
  double matched_share = 0.0;           // of the points, on walls of the map
  std::string reason = {};
};

// Is the prediction sure enough for scans to tell a pose from that of a look-alike? Without that, no search is made.
bool IsSureEnoughForScans(const PoseWithCovariance& predicted, const DoorClosureOptions& options);

// Matches `points` (the robot's frame) with what scans have `seen` of a map (null: nothing), around the graph's
// prediction of the robot's pose: an exhaustive search (SearchPose), refined and judged as SLAM judges a loop closure
// (MatchLoop). Accepted if most of the points lie on walls of the map and hardly any in its free space, the walls
// determine the pose in all directions, nothing else in the window fits nearly as well, the pose passes the gate, and
// the pose cannot be that of a look-alike. For the last one, let e be the prediction's error (95 %) and d the distance
// from the prediction to the pose. The robot is within e of the prediction, so a look-alike, alike_distance away or
// more, is farther than alike_distance - e from the prediction; d must be less. If e alone is more, no search is made
// (IsSureEnoughForScans).
ScanLocation LocateByScans(const SeenGround* seen, const std::vector<Eigen::Vector2d>& points,
                           const PoseWithCovariance& predicted, const DoorClosureOptions& options);

}  // namespace enfilade::closure
