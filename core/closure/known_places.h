// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "core/base/ids.h"
#include "core/closure/closure_options.h"
#include "core/geometry/pose2.h"
#include "core/graph/link_point.h"

namespace enfilade::closure {

// A place that the robot's own map knows, near where it saw or passed a door.
struct KnownPlace {
  const graph::LinkPoint* link_point = nullptr;
  double chi2 = 0.0;      // of the door's pose against the anchor; with FindSighted 0
  double distance = 0.0;  // m
  std::string reason;
};

// The places of `map` that a robot at `T_map_robot`, looking at a door, has before it: other sightings within
// known_along and known_across, link points that are the door itself up to known_ahead before it; each widened by the
// 95 % circle of both covariances. Sightings must face the same way within known_facing, doors that way or the
// opposite. The nearest first. `link_points`: those with an anchor in `map`; others are left out.
std::vector<KnownPlace> FindSighted(const std::vector<const graph::LinkPoint*>& link_points, const MapId& map,
                                    const PoseWithCovariance& T_map_robot, const DoorClosureOptions& options);

// The link points and candidates of `map` that may be the door at `T_map_door` which the robot has driven through: the
// gate on both poses, either way round. Candidates were seen from before the door: they are those that FindSighted
// would have the robot see from latch_distance before it. The likeliest first.
std::vector<KnownPlace> FindPassed(const std::vector<const graph::LinkPoint*>& link_points, const MapId& map,
                                   const PoseWithCovariance& T_map_door, const DoorClosureOptions& options);

// Is the door at `T_map_door`, looking into the map that the anchor is in, the one that the anchor is of? Who comes
// into a room by another door sees the same room. A link point's anchor must agree with it, either way round; a
// candidate's must have it ahead, as FindSighted has it, and look against the way through.
bool IsDoorOf(const graph::LinkPoint& link_point, const graph::Anchor& anchor, const PoseWithCovariance& T_map_door,
              const DoorClosureOptions& options);

}  // namespace enfilade::closure
