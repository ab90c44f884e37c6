// SPDX-License-Identifier: Apache-2.0
#include "server/app/graph/link_point_search.h"

#include <cmath>
#include <limits>
#include <utility>

#include "core/base/error.h"
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

// The place of the search's map. Reads nothing for a search that is in no map.
absl::StatusOr<std::optional<PoseWithCovariance>> FindMap(const LinkPointSearchStores& stores,
                                                          const storage::CallContext& context, const SiteId& site,
                                                          const LinkPointSearch& search) {
  std::optional<PoseWithCovariance> T_world_map;
  const auto* pose = std::get_if<PoseInMap>(&search.around);
  if (pose == nullptr) return T_world_map;
  ENFILADE_ASSIGN_OR_RETURN(const auto places, stores.graph.GetPlaces(context, site, {pose->map}));
  if (places.empty()) {
    ENFILADE_RETURN_IF_ERROR(stores.maps.Get(context, site, pose->map).status());
  } else {
    T_world_map = places.front().T_world_map;
  }
  return T_world_map;
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

absl::StatusOr<LinkPointSearchResult> SearchLinkPoints(const LinkPointSearchStores& stores,
                                                       const storage::CallContext& context, const SiteId& site,
                                                       const LinkPointSearch& search) {
  ENFILADE_ASSIGN_OR_RETURN(const auto T_world_map, FindMap(stores, context, site, search));
  ENFILADE_ASSIGN_OR_RETURN(const LinkPointSearchPlan plan, PlanLinkPointSearch(search, T_world_map));
  LinkPointSearchResult result;
  result.T_world_center = plan.T_world_center;
  if (plan.query) {
    ENFILADE_ASSIGN_OR_RETURN(storage::FoundLinkPoints placed, stores.link_points.Find(context, site, *plan.query));
    result.graph_version = placed.graph_version;
    if (const auto* circle = std::get_if<storage::LinkPointCircle>(&plan.query->area)) result.radius_m = circle->radius;
    result.found.reserve(placed.link_points.size());
    for (storage::StoredLinkPoint& link_point : placed.link_points) {
      const auto offset = OffsetFrom(plan.T_world_center, link_point);
      result.found.push_back({std::move(link_point), offset});
    }
  }
  if (plan.with_unplaced) {
    ENFILADE_ASSIGN_OR_RETURN(auto unplaced, stores.link_points.ListUnplaced(context, site, kMaxUnplaced));
    for (storage::StoredLinkPoint& link_point : unplaced) {
      result.found.push_back({std::move(link_point), std::nullopt});
    }
  }
  if (!plan.query) {
    ENFILADE_ASSIGN_OR_RETURN(result.graph_version, stores.graph.GetVersion(context, site));
  }
  return result;
}

}  // namespace enfilade::server
