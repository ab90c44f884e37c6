// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "core/base/ids.h"
#include "core/closure/closure_options.h"
#include "core/geometry/pose2.h"
#include "core/graph/link_point.h"

namespace enfilade::closure {

// A place of the robot's own map, near where the robot saw or passed a door.
struct KnownPlace {
  const graph::LinkPoint* link_point = nullptr;
  double chi2 = 0.0;      // of the door's pose against the anchor; 0 from FindSighted
  double distance = 0.0;  // m
  std::string reason;
};

// The places of `map` that may be the door which a robot at `T_map_robot` sees ahead: other sightings (candidates)
// within known_along and known_across, and link points, which are at the door itself, up to known_ahead ahead. Each
// bound is widened by the 95 % circle of both covariances. Sightings must face the same way within known_facing, link
// points that way or the opposite. The nearest first. Link points without an anchor in `map` and suspended ones are
// left out.
std::vector<KnownPlace> FindSighted(const std::vector<const graph::LinkPoint*>& link_points, const MapId& map,
                                    const PoseWithCovariance& T_map_robot, const DoorClosureOptions& options);

// The link points and candidates of `map` that may be the door at `T_map_door` which the robot has driven through. A
// link point's pose must pass the gate, from either side. Candidates were made in front of the door: they are those
// that FindSighted finds for a robot latch_distance before it. The likeliest first.
std::vector<KnownPlace> FindPassed(const std::vector<const graph::LinkPoint*>& link_points, const MapId& map,
                                   const PoseWithCovariance& T_map_door, const DoorClosureOptions& options);

// Is the door at `T_map_door`, looking into the anchor's map, the door of this link point? A robot that enters a room
// by another door sees the same room, so that images and clouds cannot tell. A link point's anchor must agree with the
// door's pose, from either side; a candidate's must have it ahead, as in FindSighted, and face against the way through.
bool IsDoorOf(const graph::LinkPoint& link_point, const graph::Anchor& anchor, const PoseWithCovariance& T_map_door,
              const DoorClosureOptions& options);

}  // namespace enfilade::closure
