// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/graph/search_radius.h"
#include "proto/convert/geometry.h"
#include "proto/convert/names.h"
#include "server/rpc/link_point/convert.h"
#include "server/rpc/link_point/handlers.h"
#include "server/rpc/resources.h"

namespace enfilade::server {
namespace {

constexpr int kMaxCount = 1000;
struct Search {
  std::optional<storage::LinkPointQuery> query;  // unset: the map has no place in the world
  std::optional<PoseWithCovariance> center;
  bool unplaced = false;  // also what has no place
};

absl::StatusOr<double> RadiusAround(const v1::FindLinkPointsRequest& request, const Eigen::Matrix3d& covariance) {
  graph::SearchRadiusOptions options;
  if (request.base_radius_m() != 0.0) options.base_m = request.base_radius_m();
  if (request.radius_factor() != 0.0) options.factor = request.radius_factor();
  if (!(options.base_m > 0.0 && std::isfinite(options.base_m))) {
    return InvalidArgument("base_radius_m is {}: expected more than 0", options.base_m);
  }
  if (!(options.factor > 0.0 && std::isfinite(options.factor))) {
    return InvalidArgument("radius_factor is {}: expected more than 0", options.factor);
  }
  return graph::SearchRadius(covariance, options);
}

absl::Status SearchAroundPose(const v1::FindLinkPointsRequest& request, const PoseWithCovariance& T_world_robot,
                              Search& search) {
  ENFILADE_ASSIGN_OR_RETURN(const double radius, RadiusAround(request, T_world_robot.covariance));
  search.center = T_world_robot;
  search.query->area = storage::LinkPointCircle{T_world_robot.pose.translation(), radius};
  return absl::OkStatus();
}

absl::Status SearchInMap(const Services& services, const Call& call, const SiteId& site,
                         const v1::FindLinkPointsRequest& request, Search& search) {
  ENFILADE_ASSIGN_OR_RETURN(const MapId map, MapOfSite("pose_in_map.map", site, request.pose_in_map().map()));
  ENFILADE_ASSIGN_OR_RETURN(
      const PoseWithCovariance T_map_robot,
      enfilade::convert::FromProto("pose_in_map.pose_map_robot", request.pose_in_map().pose_map_robot()));
  ENFILADE_ASSIGN_OR_RETURN(const auto places, services.graph_store.GetPlaces(call.context(), site, {map}));
  if (!places.empty()) return SearchAroundPose(request, Compose(places[0].T_world_map, T_map_robot), search);
  ENFILADE_RETURN_IF_ERROR(services.maps.Get(call.context(), site, map).status());
  // Nothing is known about how far anything is: all that could be there, as the predecessor did.
  search.query.reset();
  search.unplaced = true;
  return absl::OkStatus();
}

absl::StatusOr<Search> SearchOf(const Services& services, const Call& call, const SiteId& site,
                                const v1::FindLinkPointsRequest& request) {
  Search search;
  storage::LinkPointQuery& query = search.query.emplace();
  if (request.max_count() < 0) return InvalidArgument("max_count is {}: expected 0 or more", request.max_count());
  query.limit = request.max_count() == 0 ? kMaxCount : std::min(request.max_count(), kMaxCount);
  if (request.has_level()) query.level = request.level();
  ENFILADE_ASSIGN_OR_RETURN(query.candidate, CandidatesOf(request.subset()));
  query.with_unused = request.include_unused();
  search.unplaced = request.include_unplaced();
  switch (request.around_case()) {
    case v1::FindLinkPointsRequest::kPoseInMap:
      ENFILADE_RETURN_IF_ERROR(SearchInMap(services, call, site, request, search));
      return search;
    case v1::FindLinkPointsRequest::kPoseWorld: {
      ENFILADE_ASSIGN_OR_RETURN(const PoseWithCovariance pose,
                                enfilade::convert::FromProto("pose_world", request.pose_world()));
      ENFILADE_RETURN_IF_ERROR(SearchAroundPose(request, pose, search));
      return search;
    }
    case v1::FindLinkPointsRequest::kPointWorld: {
      const v1::Point& point = request.point_world();
      const double radius = request.has_radius_m() ? request.radius_m() : std::numeric_limits<double>::infinity();
      query.area = storage::LinkPointCircle{{point.x(), point.y()}, radius};
      search.center = PoseWithCovariance{{point.x(), point.y(), 0.0}};
      return search;
    }
    case v1::FindLinkPointsRequest::kPolygonWorld: {
      std::vector<Eigen::Vector2d> corners;
      for (const v1::Point& corner : request.polygon_world().corners()) corners.emplace_back(corner.x(), corner.y());
      query.area = std::move(corners);
      return search;
    }
    case v1::FindLinkPointsRequest::AROUND_NOT_SET:
      break;
  }
  return InvalidArgument("nothing says where to look: set pose_in_map, pose_world, point_world or polygon_world");
}

void Describe(const storage::StoredLinkPoint& link_point, const std::optional<PoseWithCovariance>& center,
              v1::FoundLinkPoint& found) {
  ToProto(link_point, *found.mutable_link_point());
  if (!center || !link_point.T_world_place) {
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    found.set_distance_m(kNone);
    found.set_bearing_rad(kNone);
    found.set_mahalanobis_distance(kNone);
    return;
  }
  const Eigen::Vector2d place = link_point.T_world_place->pose.translation();
  const Pose2 world_axes_at_center = {center->pose.x, center->pose.y, 0.0};
  found.set_distance_m((place - center->pose.translation()).norm());
  found.set_bearing_rad(graph::Bearing(world_axes_at_center, place));
  found.set_mahalanobis_distance(
      graph::MahalanobisDistance(*center, *link_point.T_world_place).value_or(std::numeric_limits<double>::infinity()));
}

}  // namespace

absl::Status FindLinkPoints(const Services& services, const Call& call, const v1::FindLinkPointsRequest& request,
                            v1::FindLinkPointsResponse& response) {
  ENFILADE_ASSIGN_OR_RETURN(const SiteId site, convert::ParseSiteName("parent", request.parent()));
  ENFILADE_ASSIGN_OR_RETURN(const Search search, SearchOf(services, call, site, request));
  if (search.query) {
    ENFILADE_ASSIGN_OR_RETURN(const auto found, services.link_points.Find(call.context(), site, *search.query));
    for (const storage::StoredLinkPoint& link_point : found.link_points) {
      Describe(link_point, search.center, *response.add_found());
    }
    response.set_graph_version(found.graph_version);
    if (const auto* circle = std::get_if<storage::LinkPointCircle>(&search.query->area))
      response.set_radius_m(circle->radius);
  }
  if (search.center) enfilade::convert::ToProto(*search.center, *response.mutable_pose_world());
  if (search.unplaced) {
    ENFILADE_ASSIGN_OR_RETURN(const auto found, services.link_points.ListUnplaced(call.context(), site, kMaxCount));
    for (const storage::StoredLinkPoint& link_point : found) Describe(link_point, std::nullopt, *response.add_found());
  }
  if (!search.query) {
    ENFILADE_ASSIGN_OR_RETURN(const std::int64_t version, services.graph_store.GetVersion(call.context(), site));
    response.set_graph_version(version);
  }
  return absl::OkStatus();
}

}  // namespace enfilade::server
