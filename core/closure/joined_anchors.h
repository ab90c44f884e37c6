// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "core/base/ids.h"
#include "core/closure/closure_options.h"
#include "core/geometry/pose2.h"
#include "core/graph/link_point.h"

namespace enfilade::closure {

// The door as both maps see it, from one robot's poses in both at one moment: in the other map T_that_door =
// T_that_robot * T_this_robot^-1 * T_this_door. The covariance there is that of the robot's pose there, carried to the
// door; here it is the door's own. So the chain across the door has both, and the closure tells of the orientation,
// too.
struct JoinedAnchors {
  graph::Anchor here;
  graph::Anchor there;
};
JoinedAnchors JoinAtDoor(const MapId& here, const Pose2& T_here_robot, const PoseWithCovariance& T_here_door,
                         const MapId& there, const PoseWithCovariance& T_there_robot);

// The door as the origin of a map that begins there, looking into it.
graph::Anchor OriginAnchor(const MapId& map, const DoorClosureOptions& options);

// Where a robot at T_here_robot is in `there`, which the link point joins with `here`: T_there_place * T_here_place^-1
// * T_here_robot. Unset where it has no anchor in one of them.
std::optional<PoseWithCovariance> PoseBehind(const graph::LinkPoint& link_point, const MapId& here, const MapId& there,
                                             const PoseWithCovariance& T_here_robot);

// A link point of `link_points` that joins the same two maps at the same place: as the database sees it (within the 95
// % circle of both covariances, at least 0.3 m, in each of them), or null.
const graph::LinkPoint* FindRedundant(const std::vector<const graph::LinkPoint*>& link_points,
                                      const JoinedAnchors& anchors);

}  // namespace enfilade::closure
