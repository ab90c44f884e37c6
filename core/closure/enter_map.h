// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "core/base/ids.h"
#include "core/closure/door_action.h"
#include "core/closure/door_knowledge.h"
#include "core/geometry/pose2.h"
#include "core/graph/link_point.h"

namespace enfilade::closure {

// The known map that a robot has entered through a door.
struct Destination {
  MapId map = {};
  const graph::LinkPoint* link_point = nullptr;  // in `map`, that it may have come through; null: none is known there
  PoseWithCovariance T_map_robot = {};           // when it reports
  std::string reason = {};
};

// What to do about a passage into a known map. If the passed door is the destination's link point, that one is
// recognised, joined to the session's map, or (a candidate) promoted; if another link point joins the two maps at this
// door, that one is recognised; otherwise the door is a new link point between the two maps. Candidates of the
// session's map that were sightings of this door are used up. Of the knowledge: passed, the poses, and the graph.
DoorJudgement EnterKnownMap(const DoorKnowledge& knowledge, const Destination& to);

// What to do about a passage into a map that is not known: a new link point, and a new map whose origin it is.
DoorJudgement StartNewMap(const DoorKnowledge& knowledge, std::string reason);

// What to do about a passage whose door was not mapped (knowledge.by_odometry is set): the same, by odometry alone, so
// that one robot's maps are always joined.
DoorJudgement JoinByOdometry(const DoorKnowledge& knowledge, std::string reason);

}  // namespace enfilade::closure
