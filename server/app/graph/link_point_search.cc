// SPDX-License-Identifier: Apache-2.0
#include "server/app/graph/link_point_search.h"

#include <cmath>
#include <limits>
#include <utility>

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/status_macros.h"

namespace enfilade::server {
namespace {

constexpr int kMaxUnplaced = 1000;

absl::Status CheckRadius(const graph::SearchRadiusOptions& options) {
  if (!(options.base_m > 0.0 && std::isfinite(options.base_m))) {
    return InvalidArgument("base_radius_m is {}: expected more than 0", options.base_m);
  }
  if (!(options.factor > 0.0 && std::isfinite(options.factor))) {
    return InvalidArgument("radius_factor is {}: expected more than 0", options.factor);
  }
  return absl::OkStatus();
}

absl::Status PlanAroundPose(const LinkPointSearch& search, const PoseWithCovariance& T_world_robot,
                            LinkPointSearchPlan& plan) {
  ENFILADE_RETURN_IF_ERROR(CheckRadius(search.radius));
  plan.T_world_center = T_world_robot;
  plan.query->area = storage::LinkPointCircle{T_world_robot.pose.translation(),
                                              graph::SearchRadius(T_world_robot.covariance, search.radius)};
  return absl::OkStatus();
}

// The place of the search's map; none for a search that is in no map.
absl::StatusOr<std::optional<PoseWithCovariance>> FindMap(const SiteId& site, const SiteGraph& graph,
                                                          const LinkPointSearch& search) {
  const auto* pose = std::get_if<PoseInMap>(&search.around);
  if (pose == nullptr) return std::optional<PoseWithCovariance>();
  const int slot = graph.graph().MapSlot(pose->map);
  if (slot < 0) return NotFound("{} does not exist", NameOf(site, pose->map));
  return graph.placed.PlaceOfMap(slot);
}

}  // namespace

absl::StatusOr<LinkPointSearchPlan> PlanLinkPointSearch(const LinkPointSearch& search,
                                                        const std::optional<PoseWithCovariance>& T_world_map) {
  LinkPointSearchPlan plan;
  plan.with_unplaced = search.with_unplaced;
  storage::LinkPointQuery& query = plan.query.emplace();
  query.level = search.level;
  query.candidate = search.candidate;
  query.with_unused = search.with_unused;
  query.limit = search.limit;
  if (const auto* in_map = std::get_if<PoseInMap>(&search.around)) {
    if (T_world_map) {
      ENFILADE_RETURN_IF_ERROR(PlanAroundPose(search, Compose(*T_world_map, in_map->T_map_robot), plan));
    } else {
      // How far anything is, is unknown: the answer is everything that could be there.
      plan.query.reset();
      plan.with_unplaced = true;
    }
  } else if (const auto* pose = std::get_if<PoseWithCovariance>(&search.around)) {
    ENFILADE_RETURN_IF_ERROR(PlanAroundPose(search, *pose, plan));
  } else if (const auto* circle = std::get_if<storage::LinkPointCircle>(&search.around)) {
    query.area = *circle;
    plan.T_world_center = PoseWithCovariance{{circle->center.x(), circle->center.y(), 0.0}};
  } else {
    query.area = std::get<std::vector<Eigen::Vector2d>>(search.around);
  }
  return plan;
}

std::optional<FoundLinkPoint::Offset> OffsetFrom(const std::optional<PoseWithCovariance>& T_world_center,
                                                 const storage::StoredLinkPoint& link_point) {
  if (!T_world_center || !link_point.T_world_place) return std::nullopt;
  const Eigen::Vector2d place = link_point.T_world_place->pose.translation();
  const Pose2 world_axes_at_center = {T_world_center->pose.x, T_world_center->pose.y, 0.0};
  return FoundLinkPoint::Offset{
      .distance_m = (place - T_world_center->pose.translation()).norm(),
      .bearing_rad = graph::Bearing(world_axes_at_center, place),
      .mahalanobis_distance = graph::MahalanobisDistance(*T_world_center, *link_point.T_world_place)
                                  .value_or(std::numeric_limits<double>::infinity())};
}

absl::StatusOr<LinkPointSearchPlan> PlanLinkPointSearchIn(const SiteId& site, const SiteGraph& graph,
                                                          const LinkPointSearch& search) {
  ENFILADE_ASSIGN_OR_RETURN(const auto T_world_map, FindMap(site, graph, search));
  return PlanLinkPointSearch(search, T_world_map);
}

absl::StatusOr<LinkPointSearchResult> SearchLinkPoints(std::shared_ptr<const SiteGraph> graph,
                                                       const LinkPointSearchPlan& plan) {
  LinkPointSearchResult result;
  result.T_world_center = plan.T_world_center;
  if (plan.query) {
    ENFILADE_ASSIGN_OR_RETURN(const auto placed, graph->placed.Find(graph->graph(), *plan.query));
    if (const auto* circle = std::get_if<storage::LinkPointCircle>(&plan.query->area)) result.radius_m = circle->radius;
    for (const storage::StoredLinkPoint* link_point : placed) {
      result.found.push_back({link_point, OffsetFrom(plan.T_world_center, *link_point)});
    }
  }
  if (plan.with_unplaced) {
    for (const storage::StoredLinkPoint* link_point : graph->placed.ListUnplaced(kMaxUnplaced)) {
      result.found.push_back({link_point, std::nullopt});
    }
  }
  result.graph = std::move(graph);
  return result;
}

}  // namespace enfilade::server
