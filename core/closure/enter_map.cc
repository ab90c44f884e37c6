// SPDX-License-Identifier: Apache-2.0
#include "core/closure/enter_map.h"

#include <utility>
#include <vector>

#include "core/closure/joined_anchors.h"
#include "core/closure/known_places.h"

namespace enfilade::closure {
namespace {

EnteredMap Entered(const Destination& to) { return {.map = to.map, .T_map_robot = to.T_map_robot}; }

DoorJudgement Promote(const DoorKnowledge& knowledge, const Destination& to, const JoinedAnchors& joined) {
  PromoteCandidate action;
  action.link_point = to.link_point->id;
  action.kind = knowledge.report.place;
  action.anchors = {joined.there, joined.here};
  action.entered = Entered(to);
  return {.action = std::move(action), .reason = to.reason};
}

// Joins the session's map to a link point that has an anchor `seen` in the destination.
DoorJudgement Join(const DoorKnowledge& knowledge, const Destination& to, const graph::Anchor& seen) {
  const PoseWithCovariance T_robot_place{Between(to.T_map_robot.pose, seen.T_map_place), to.T_map_robot.covariance};
  const PoseWithCovariance T_here_place = Compose(*knowledge.T_map_robot, T_robot_place);
  JoinLinkPoint action;
  action.link_point = to.link_point->id;
  action.anchor = {knowledge.map->id, T_here_place.pose, T_here_place.covariance};
  action.entered = Entered(to);
  return {.action = std::move(action), .reason = to.reason + "; this map is joined to it, too"};
}

DoorJudgement Link(const DoorKnowledge& knowledge, const Destination& to, const JoinedAnchors& joined) {
  LinkKnownMaps action;
  action.link_point.id = knowledge.new_link_point;
  action.link_point.kind = knowledge.report.place;
  action.link_point.direction = joined.there.map;
  action.link_point.anchors = {joined.here, joined.there};
  action.entered = Entered(to);
  return {.action = std::move(action), .reason = "another door of a map that is known: " + to.reason};
}

// A new map whose origin is the door.
DoorJudgement StartMapBehind(const DoorKnowledge& knowledge, const PoseWithCovariance& T_map_door,
                             const std::optional<PoseWithCovariance>& T_door_robot, std::string reason) {
  StartMap action;
  action.map = DescribeNewMap(knowledge.new_map, &*knowledge.map, &knowledge.report, knowledge.options);
  action.link_point.id = knowledge.new_link_point;
  action.link_point.kind = knowledge.report.place;
  action.link_point.direction = action.map.id;
  action.link_point.anchors = {{knowledge.map->id, T_map_door.pose, T_map_door.covariance},
                               OriginAnchor(action.map.id, knowledge.options)};
  action.entered = {.map = action.map.id, .T_map_robot = T_door_robot};  // the door is the map's origin
  return {.action = std::move(action), .reason = std::move(reason)};
}

}  // namespace

DoorJudgement EnterKnownMap(const DoorKnowledge& knowledge, const Destination& to) {
  const MapId& here = knowledge.map->id;
  const JoinedAnchors joined =
      JoinAtDoor(here, knowledge.T_map_robot->pose, *knowledge.T_map_door, to.map, to.T_map_robot);
  const graph::Anchor* seen = to.link_point != nullptr ? to.link_point->FindAnchor(to.map) : nullptr;
  const bool is_door =
      seen != nullptr &&
      IsDoorOf(*to.link_point, *seen, {joined.there.T_map_place, joined.there.covariance}, knowledge.options);
  std::vector<LinkPointId> used_up = knowledge.passed->sightings;
  DoorJudgement judgement;
  if (is_door && !to.link_point->is_candidate() && to.link_point->FindAnchor(here) != nullptr) {
    judgement = {.action = RecogniseLinkPoint{to.link_point->id, Entered(to)}, .reason = to.reason};
  } else if (const graph::LinkPoint* other = FindRedundant(knowledge.graph->ListLinkPointsIn(here), joined)) {
    if (is_door && to.link_point->is_candidate()) used_up.push_back(to.link_point->id);
    judgement = {.action = RecogniseLinkPoint{other->id, Entered(to)},
                 .reason = to.reason + "; a link point joins the maps at that place already"};
  } else if (!is_door || (!to.link_point->is_candidate() && knowledge.redundant.contains(to.link_point->id))) {
    judgement = Link(knowledge, to, joined);
  } else if (to.link_point->is_candidate()) {
    judgement = Promote(knowledge, to, joined);
  } else {
    judgement = Join(knowledge, to, *seen);
  }
  judgement.used_up = std::move(used_up);
  return judgement;
}

DoorJudgement StartNewMap(const DoorKnowledge& knowledge, std::string reason) {
  DoorJudgement judgement = StartMapBehind(knowledge, *knowledge.T_map_door, knowledge.T_door_robot, std::move(reason));
  judgement.used_up = knowledge.passed->sightings;
  return judgement;
}

DoorJudgement JoinByOdometry(const DoorKnowledge& knowledge, std::string reason) {
  return StartMapBehind(knowledge, knowledge.by_odometry->T_map_door, knowledge.by_odometry->T_door_robot,
                        std::move(reason) + "; odometry joins a new map");
}

}  // namespace enfilade::closure
