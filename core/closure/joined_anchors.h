// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "core/base/ids.h"
#include "core/closure/closure_options.h"
#include "core/geometry/pose2.h"
#include "core/graph/link_point.h"

namespace enfilade::closure {

// The anchors of one door in two maps, from one robot's poses in both at the same time: T_there_door = T_there_robot *
// T_here_robot^-1 * T_here_door. The covariance there is that of the robot's pose there, propagated to the door; here
// it is the door's own. The chain across the door then has both covariances, orientation included.
struct JoinedAnchors {
  graph::Anchor here;
  graph::Anchor there;
};
JoinedAnchors JoinAtDoor(const MapId& here, const Pose2& T_here_robot, const PoseWithCovariance& T_here_door,
                         const MapId& there, const PoseWithCovariance& T_there_robot);

// The anchor of a door that is the origin of a new map, looking into it.
graph::Anchor OriginAnchor(const MapId& map, const DoorClosureOptions& options);

// The pose in `there` of a robot at T_here_robot, by a link point that joins both maps: T_there_place * T_here_place^-1
// * T_here_robot. Unset if the link point has no anchor in one of them.
std::optional<PoseWithCovariance> PoseAcross(const graph::LinkPoint& link_point, const MapId& here, const MapId& there,
                                             const PoseWithCovariance& T_here_robot);

// The first of `link_points` that joins the same two maps at the same place (graph::FindCommonPlace) and is not
// suspended. Null if there is none.
const graph::LinkPoint* FindRedundant(const std::vector<const graph::LinkPoint*>& link_points,
                                      const JoinedAnchors& anchors);

}  // namespace enfilade::closure
