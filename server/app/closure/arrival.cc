// SPDX-License-Identifier: Apache-2.0
#include "server/app/closure/arrival.h"

#include <utility>

#include "core/base/status_macros.h"
#include "core/base/uuid.h"
#include "core/closure/joined_anchors.h"
#include "core/closure/known_places.h"
#include "server/app/closure/door_evidence.h"
#include "server/app/closure/report_judge.h"

namespace enfilade::server {
namespace {

// A link point between two maps that are there already.
void JoinKnown(const PassageScene& passage, const closure::JoinedAnchors& joined, const Destination& to,
               storage::DoorChange& change) {
  storage::StoredLinkPoint made;
  made.site = passage.map.site;
  made.point.id = LinkPointId(NewUuid());
  made.point.kind = passage.report.place;
  made.point.direction = joined.there.map;
  made.point.anchors = {joined.here, joined.there};
  KeepEvidenceHere(passage, made.point.id, change);
  KeepEvidenceBehind(passage, made.point.id, joined.there, change);
  change.verdict.decision = closure::DoorDecision::kLinkPointMade;
  change.verdict.link_point = made.point.id;
  change.verdict.entered_map = joined.there.map;
  change.verdict.T_map_robot = to.T_map_robot;
  change.verdict.reason = "another door of a map that is known: " + to.reason;
  change.new_link_point = std::move(made);
}

}  // namespace

void Recognise(const graph::LinkPoint& link_point, const MapId& map, const PoseWithCovariance& T_map_robot,
               std::string why, closure::DoorVerdict& verdict) {
  verdict.decision = closure::DoorDecision::kLinkPointRecognised;
  verdict.link_point = link_point.id;
  verdict.entered_map = map;
  verdict.T_map_robot = T_map_robot;
  verdict.reason = std::move(why);
}

absl::Status Arrive(const storage::CallContext& context, const PassageScene& passage, const Destination& to,
                    const std::vector<LinkPointId>& own, storage::DoorChange& change) {
  const MapId& here = passage.map.id;
  const MapId& there = to.map;
  change.consumed = own;
  const closure::JoinedAnchors joined =
      closure::JoinAtDoor(here, passage.T_map_robot.pose, passage.T_map_door, there, to.T_map_robot);
  const graph::Anchor* seen = to.link_point != nullptr ? to.link_point->FindAnchor(there) : nullptr;
  const bool is_door =
      seen != nullptr &&
      closure::IsDoorOf(*to.link_point, *seen, {joined.there.T_map_place, joined.there.covariance}, passage.options);
  if (is_door && !to.link_point->is_candidate() && to.link_point->FindAnchor(here) != nullptr) {
    Recognise(*to.link_point, there, to.T_map_robot, to.reason, change.verdict);
    return absl::OkStatus();
  }
  const std::vector<const graph::LinkPoint*> all = passage.graph.graph().ListLinkPoints();
  if (const graph::LinkPoint* other = closure::FindRedundant(all, joined); other != nullptr) {
    if (is_door && to.link_point->is_candidate()) change.consumed.push_back(to.link_point->id);
    Recognise(*other, there, to.T_map_robot, to.reason + "; a link point joins the maps at that place already",
              change.verdict);
    return absl::OkStatus();
  }
  if (!is_door) {
    JoinKnown(passage, joined, to, change);
    return absl::OkStatus();
  }
  const graph::LinkPoint& point = *to.link_point;
  ENFILADE_ASSIGN_OR_RETURN(storage::StoredLinkPoint stored,
                            passage.stores.link_points.Get(context, passage.map.site, point.id));
  if (point.is_candidate()) {
    // The candidate was seen from before the door; the link point is the door.
    stored.point.anchors = {joined.there, joined.here};
    stored.point.direction = there;
    stored.point.kind = passage.report.place;
    change.verdict.decision = closure::DoorDecision::kCandidatePromoted;
    change.verdict.link_point = point.id;
    change.verdict.entered_map = there;
    change.verdict.T_map_robot = to.T_map_robot;
    change.verdict.reason = to.reason;
  } else {
    const PoseWithCovariance T_robot_place{Between(to.T_map_robot.pose, seen->T_map_place), to.T_map_robot.covariance};
    const PoseWithCovariance T_here_place = Compose(passage.T_map_robot, T_robot_place);
    stored.point.anchors.push_back({here, T_here_place.pose, T_here_place.covariance});
    Recognise(point, there, to.T_map_robot, to.reason + "; this map is joined to it, too", change.verdict);
  }
  change.link_point = std::move(stored);
  KeepEvidenceHere(passage, point.id, change);
  return absl::OkStatus();
}

void Begin(const PassageScene& passage, const std::vector<LinkPointId>& own, std::string why,
           storage::DoorChange& change) {
  change.new_map = MapBehind(passage.map, &passage.report, passage.options);
  change.consumed = own;
  storage::StoredLinkPoint made;
  made.site = passage.map.site;
  made.environment = change.new_map->environment;
  graph::LinkPoint& point = made.point;
  point.id = LinkPointId(NewUuid());
  point.kind = passage.report.place;
  point.direction = change.new_map->id;
  point.anchors = {{passage.map.id, passage.T_map_door.pose, passage.T_map_door.covariance},
                   closure::OriginAnchor(change.new_map->id, passage.options)};
  KeepEvidenceHere(passage, point.id, change);
  KeepEvidenceBehind(passage, point.id, point.anchors.back(), change);
  closure::DoorVerdict& verdict = change.verdict;
  verdict.decision = closure::DoorDecision::kLinkPointMade;
  verdict.link_point = point.id;
  verdict.entered_map = change.new_map->id;
  verdict.T_map_robot = passage.scene.RobotFromDoor();  // the door is the new map's origin
  verdict.reason = std::move(why);
  change.new_link_point = std::move(made);
}

}  // namespace enfilade::server
