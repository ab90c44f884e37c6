// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/rearrange/plan.h"

namespace enfilade::rearrange {
namespace {

constexpr double kNowhere = std::numeric_limits<double>::infinity();

// The keyframes of a map by the part that they will be in.
struct Parts {
  std::vector<Eigen::Vector2d> staying, leaving;
};

const SessionInMap* FindSession(const MapContent& map, const SessionId& id) {
  const auto found = std::find_if(map.sessions.begin(), map.sessions.end(),
                                  [&](const SessionInMap& session) { return session.id == id; });
  return found == map.sessions.end() ? nullptr : &*found;
}

absl::Status CheckLeaving(const SplitRequest& request) {
  std::set<SessionId> seen;
  const auto check = [&](const SessionId& id) {
    const SessionInMap* session = FindSession(request.map, id);
    if (session == nullptr) return NotFound("session {} is not in map {}", id.value(), request.map.id.value());
    if (!seen.insert(id).second) return InvalidArgument("session {} is given twice", id.value());
    if (session->mapped) return absl::OkStatus();
    return FailedPrecondition("session {} is still recording or being mapped", id.value());
  };
  for (const SessionId& id : request.leaving) ENFILADE_RETURN_IF_ERROR(check(id));
  for (const SessionCut& cut : request.cuts) ENFILADE_RETURN_IF_ERROR(check(cut.session));
  if (request.leaving.empty() && request.cuts.empty()) {
    return FailedPrecondition("map {} is not divided: no session leaves it", request.map.id.value());
  }
  if (request.leaving.size() == request.map.sessions.size()) {
    return FailedPrecondition("map {} is not divided: all its {} sessions would leave it", request.map.id.value(),
                              request.map.sessions.size());
  }
  return absl::OkStatus();
}

absl::StatusOr<Parts> Divide(const SplitRequest& request) {
  const std::set<SessionId> leaving(request.leaving.begin(), request.leaving.end());
  Parts parts;
  for (const SessionInMap& session : request.map.sessions) {
    const auto cut = std::find_if(request.cuts.begin(), request.cuts.end(),
                                  [&](const SessionCut& c) { return c.session == session.id; });
    std::size_t behind = 0;
    for (const Keyframe& keyframe : session.keyframes) {
      const bool leaves =
          leaving.contains(session.id) || (cut != request.cuts.end() && keyframe.sequence >= cut->first_sequence);
      (leaves ? parts.leaving : parts.staying).push_back(keyframe.position);
      behind += leaves;
    }
    if (cut == request.cuts.end()) continue;
    if (behind == 0 || behind == session.keyframes.size()) {
      return FailedPrecondition("session {} has no keyframe {} record {}: there is nothing to cut off",
                                session.id.value(), behind == 0 ? "from" : "before", cut->first_sequence);
    }
  }
  return parts;
}

double DistanceTo(const std::vector<Eigen::Vector2d>& keyframes, const Eigen::Vector2d& place) {
  double nearest = kNowhere;
  for (const Eigen::Vector2d& position : keyframes) nearest = std::min(nearest, (position - place).norm());
  return nearest;
}

// Where the two parts come nearest to each other, looking into the one that leaves.
Pose2 FindDivide(const Parts& parts) {
  double nearest = kNowhere;
  Pose2 divide;
  for (const Eigen::Vector2d& from : parts.staying) {
    for (const Eigen::Vector2d& to : parts.leaving) {
      const Eigen::Vector2d way = to - from;
      if (way.norm() >= nearest) continue;
      nearest = way.norm();
      divide = {0.5 * (from.x() + to.x()), 0.5 * (from.y() + to.y()),
                nearest > 0.0 ? std::atan2(way.y(), way.x()) : 0.0};
    }
  }
  return divide;
}

graph::LinkPoint LinkParts(const SplitRequest& request, const Parts& parts) {
  const Pose2 place = FindDivide(parts);
  graph::LinkPoint point;
  point.id = request.link_point;
  point.kind = graph::LinkPointKind::kOpening;
  point.anchors = {{request.map.id, place, graph::DefaultAnchorCovariance()},
                   {request.seed.id, place, graph::DefaultAnchorCovariance()}};
  point.direction = request.seed.id;
  return point;
}

}  // namespace

absl::StatusOr<Rearrangement> PlanSplit(const SplitRequest& request, const graph::GraphSnapshot& graph) {
  const MapId& map = request.map.id;
  if (graph.FindMap(map) == nullptr) return NotFound("map {} does not exist", map.value());
  ENFILADE_RETURN_IF_ERROR(CheckLeaving(request));
  ENFILADE_ASSIGN_OR_RETURN(const Parts parts, Divide(request));

  Rearrangement plan;
  plan.new_maps.push_back(request.seed);
  plan.cuts = request.cuts;
  for (const SessionId& session : request.leaving) plan.moves.push_back({session, request.seed.id, Pose2{}});
  for (const SessionCut& cut : request.cuts) plan.moves.push_back({cut.rest, request.seed.id, Pose2{}});
  for (const graph::LinkPoint* point : graph.ListLinkPoints()) {
    const graph::Anchor* anchor = point->FindAnchor(map);
    if (anchor == nullptr) continue;
    const Eigen::Vector2d place = anchor->T_map_place.translation();
    if (DistanceTo(parts.leaving, place) >= DistanceTo(parts.staying, place)) continue;
    graph::LinkPoint moved = *point;
    for (graph::Anchor& a : moved.anchors) {
      if (a.map == map) a.map = request.seed.id;
    }
    if (moved.direction == map) moved.direction = request.seed.id;
    plan.link_points.push_back(std::move(moved));
  }
  if (!parts.staying.empty() && !parts.leaving.empty()) plan.link_points.push_back(LinkParts(request, parts));
  plan.reason = fmt::format("{} sessions of map {} get a map of their own, {} of them cut", plan.moves.size(),
                            map.value(), plan.cuts.size());
  return plan;
}

}  // namespace enfilade::rearrange
