// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/graph/global_pose.h"
#include "core/graph/same_place.h"
#include "core/rearrange/plan.h"

namespace enfilade::rearrange {
namespace {

absl::Status CheckMergeable(const MergeRequest& request, const graph::GraphSnapshot& graph) {
  const auto& [kept, merged, T_kept_merged, options] = request;
  if (kept.id == merged.id) return InvalidArgument("map {} cannot be merged with itself", kept.id.value());
  for (const MapContent* map : {&kept, &merged}) {
    if (graph.FindMap(map->id) == nullptr) return NotFound("map {} does not exist", map->id.value());
  }
  if (kept.level != merged.level) {
    return InvalidArgument("map {} is on level {} and map {} on level {}: they cannot be one room", kept.id.value(),
                           kept.level, merged.id.value(), merged.level);
  }
  if (kept.environment != merged.environment) {
    return InvalidArgument("one of the maps {} and {} is indoors and the other outdoors: they cannot be one room",
                           kept.id.value(), merged.id.value());
  }
  if (T_kept_merged && !IsFinite(*T_kept_merged)) return InvalidArgument("the pose between the maps is not finite");
  return absl::OkStatus();
}

absl::StatusOr<Pose2> FindSurePose(const graph::GraphSnapshot& graph, const MapId& kept, const MapId& merged,
                                   const MergeOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(const auto transform, graph::FindTransform(graph, kept, merged));
  if (!transform) {
    return FailedPrecondition("no link points lead from map {} to map {}: give the pose between them", kept.value(),
                              merged.value());
  }
  // At the link point that leads there: far from it, as at the map's origin, the yaw's error moves things apart.
  Pose2 T_merged_place;
  if (!transform->hops.empty()) {
    const graph::LinkPoint* last = graph.FindLinkPoint(transform->hops.back().link_point);
    const graph::Anchor* anchor = last == nullptr ? nullptr : last->FindAnchor(merged);
    if (anchor != nullptr) T_merged_place = anchor->T_map_place;
  }
  const Eigen::Matrix3d covariance = Compose(transform->T_a_b, {T_merged_place, Eigen::Matrix3d::Zero()}).covariance;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> position(covariance.topLeftCorner<2, 2>());
  const double translation_sigma = std::sqrt(std::max(0.0, position.eigenvalues()(1)));
  const double yaw_sigma = std::sqrt(std::max(0.0, covariance(2, 2)));
  if (translation_sigma > options.max_translation_sigma || yaw_sigma > options.max_yaw_sigma) {
    return FailedPrecondition(
        "the graph is not sure of the pose between map {} and map {}: {:.2f} m, {:.2f} rad (at most {:.2f} m, {:.2f} "
        "rad): give it",
        kept.value(), merged.value(), translation_sigma, yaw_sigma, options.max_translation_sigma,
        options.max_yaw_sigma);
  }
  return transform->T_a_b.pose;
}

// The link points of two maps that become one.
class JoinedLinkPoints {
 public:
  JoinedLinkPoints(const graph::GraphSnapshot& graph, MapId kept, MapId merged, const Pose2& T_kept_merged)
      : kept_(std::move(kept)), merged_(std::move(merged)), T_kept_merged_(T_kept_merged) {
    // Those of the map that stays first: they are the ones that others are joined to.
    for (const graph::LinkPoint* point : graph.ListLinkPoints()) {
      if (point->FindAnchor(kept_) != nullptr && point->FindAnchor(merged_) == nullptr) present_.push_back(*point);
    }
    for (const graph::LinkPoint* point : graph.ListLinkPoints()) {
      if (point->FindAnchor(merged_) != nullptr) Move(*point);
    }
  }

  void AddTo(Rearrangement& rearrangement) && {
    for (graph::LinkPoint& point : present_) {
      if (changed_.contains(point.id)) rearrangement.link_points.push_back(std::move(point));
    }
    rearrangement.removed_link_points = std::move(removed_);
  }

 private:
  void Move(graph::LinkPoint point) {
    const bool joins_both = point.FindAnchor(kept_) != nullptr;
    const auto anchor = std::find_if(point.anchors.begin(), point.anchors.end(),
                                     [&](const graph::Anchor& a) { return a.map == merged_; });
    if (joins_both) {
      point.anchors.erase(anchor);
      // It was the door between the two.
      if (point.anchors.size() < 2) return removed_.push_back(point.id);
    } else {
      const PoseWithCovariance moved = Moved(T_kept_merged_, {anchor->T_map_place, anchor->covariance});
      *anchor = {kept_, moved.pose, moved.covariance};
    }
    if (point.direction == merged_) point.direction = kept_;
    const auto same = std::find_if(present_.begin(), present_.end(),
                                   [&](const graph::LinkPoint& other) { return IsSamePlace(point, other); });
    if (same == present_.end()) {
      changed_.insert(point.id);
      present_.push_back(std::move(point));
      return;
    }
    for (const graph::Anchor& a : point.anchors) {
      if (same->FindAnchor(a.map) != nullptr) continue;
      same->anchors.push_back(a);
      changed_.insert(same->id);
    }
    removed_.push_back(point.id);
  }

  // A candidate is the same place as whatever is there in its map.
  bool IsSamePlace(const graph::LinkPoint& a, const graph::LinkPoint& b) const {
    if (!a.is_candidate() && !b.is_candidate()) return graph::FindCommonPlace(a.anchors, b.anchors).has_value();
    if (!a.is_candidate()) return false;
    const graph::Anchor* in_a = a.FindAnchor(kept_);
    const graph::Anchor* in_b = b.FindAnchor(kept_);
    return in_a != nullptr && in_b != nullptr &&
           (in_a->T_map_place.translation() - in_b->T_map_place.translation()).norm() <=
               graph::SamePlaceDistance(in_a->covariance, in_b->covariance);
  }

  const MapId kept_, merged_;
  const Pose2 T_kept_merged_;
  std::vector<graph::LinkPoint> present_;
  std::set<LinkPointId> changed_;
  std::vector<LinkPointId> removed_;
};

}  // namespace

absl::StatusOr<Rearrangement> PlanMerge(const MergeRequest& request, const graph::GraphSnapshot& graph) {
  ENFILADE_RETURN_IF_ERROR(CheckMergeable(request, graph));
  Pose2 T_kept_merged;
  if (request.T_kept_merged) {
    T_kept_merged = *request.T_kept_merged;
  } else {
    ENFILADE_ASSIGN_OR_RETURN(T_kept_merged, FindSurePose(graph, request.kept.id, request.merged.id, request.options));
  }
  const bool exchanged = graph.root() == request.merged.id;
  const MapContent& kept = exchanged ? request.merged : request.kept;
  const MapContent& merged = exchanged ? request.kept : request.merged;
  if (exchanged) T_kept_merged = Inverse(T_kept_merged);

  Rearrangement plan;
  for (const SessionInMap& session : merged.sessions) {
    if (!session.mapped) {
      return FailedPrecondition("session {} in map {} is still recording or being mapped", session.id.value(),
                                merged.id.value());
    }
    plan.moves.push_back({session.id, kept.id, T_kept_merged});
  }
  plan.redirects.push_back({merged.id, kept.id, T_kept_merged});
  JoinedLinkPoints(graph, kept.id, merged.id, T_kept_merged).AddTo(plan);
  plan.reason = fmt::format("map {} merged into map {}: {} sessions, at ({:.2f} m, {:.2f} m, {:.1f} deg){}",
                            merged.id.value(), kept.id.value(), plan.moves.size(), T_kept_merged.x, T_kept_merged.y,
                            T_kept_merged.yaw / kDegree, request.T_kept_merged ? " as given" : " by the graph");
  return plan;
}

}  // namespace enfilade::rearrange
