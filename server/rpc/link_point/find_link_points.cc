// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "proto/convert/geometry.h"
#include "proto/convert/names.h"
#include "server/app/graph/link_point_search.h"
#include "server/rpc/link_point/convert.h"
#include "server/rpc/link_point/handlers.h"

namespace enfilade::server {
namespace {

constexpr int kMaxCount = 1000;
constexpr double kLocalRadius = 100.0;  // m

using Around = decltype(LinkPointSearch::around);

absl::StatusOr<Around> AroundOf(const SiteId& site, const v1::FindLinkPointsRequest& request) {
  switch (request.around_case()) {
    case v1::FindLinkPointsRequest::kPoseInMap: {
      ENFILADE_ASSIGN_OR_RETURN(MapId map, MapOfSite("pose_in_map.map", site, request.pose_in_map().map()));
      ENFILADE_ASSIGN_OR_RETURN(
          const PoseWithCovariance T_map_robot,
          enfilade::convert::FromProto("pose_in_map.pose_map_robot", request.pose_in_map().pose_map_robot()));
      return Around(PoseInMap{std::move(map), T_map_robot});
    }
    case v1::FindLinkPointsRequest::kPoseWorld: {
      ENFILADE_ASSIGN_OR_RETURN(const PoseWithCovariance pose,
                                enfilade::convert::FromProto("pose_world", request.pose_world()));
      return Around(pose);
    }
    case v1::FindLinkPointsRequest::kPointWorld: {
      const v1::Point& point = request.point_world();
      const double radius = request.has_radius_m() ? request.radius_m() : std::numeric_limits<double>::infinity();
      return Around(storage::LinkPointCircle{{point.x(), point.y()}, radius});
    }
    case v1::FindLinkPointsRequest::kPolygonWorld: {
      std::vector<Eigen::Vector2d> corners;
      for (const v1::Point& corner : request.polygon_world().corners()) corners.emplace_back(corner.x(), corner.y());
      return Around(std::move(corners));
    }
    case v1::FindLinkPointsRequest::AROUND_NOT_SET:
      break;
  }
  return InvalidArgument("no place to search: set pose_in_map, pose_world, point_world or polygon_world");
}

absl::StatusOr<LinkPointSearch> SearchOf(const SiteId& site, const v1::FindLinkPointsRequest& request) {
  LinkPointSearch search;
  if (request.max_count() < 0) return InvalidArgument("max_count is {}: expected 0 or more", request.max_count());
  search.limit = request.max_count() == 0 ? kMaxCount : std::min(request.max_count(), kMaxCount);
  if (request.has_level()) search.level = request.level();
  ENFILADE_ASSIGN_OR_RETURN(search.candidate, CandidatesOf(request.subset()));
  search.with_unused = request.include_unused();
  search.with_unplaced = request.include_unplaced();
  if (request.base_radius_m() != 0.0) search.radius.base_m = request.base_radius_m();
  if (request.radius_factor() != 0.0) search.radius.factor = request.radius_factor();
  ENFILADE_ASSIGN_OR_RETURN(search.around, AroundOf(site, request));
  return search;
}

void Fill(const FoundLinkPoint& found, v1::FoundLinkPoint& out) {
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  server::ToProto(*found.link_point, *out.mutable_link_point());
  const FoundLinkPoint::Offset offset = found.offset.value_or(FoundLinkPoint::Offset{kUnknown, kUnknown, kUnknown});
  out.set_distance_m(offset.distance_m);
  out.set_bearing_rad(offset.bearing_rad);
  out.set_mahalanobis_distance(offset.mahalanobis_distance);
}

struct GivenSearch {
  SiteId site;
  LinkPointSearch search;
};

absl::StatusOr<GivenSearch> Parse(const v1::FindLinkPointsRequest& request) {
  ENFILADE_ASSIGN_OR_RETURN(SiteId site, convert::ParseSiteName("parent", request.parent()));
  ENFILADE_ASSIGN_OR_RETURN(LinkPointSearch search, SearchOf(site, request));
  return GivenSearch{std::move(site), std::move(search)};
}

// Whether the search looks at the surroundings only, so that the thread that received the call may answer it.
bool IsLocal(const LinkPointSearchPlan& plan) {
  if (plan.with_unplaced || !plan.query || plan.query->candidate == true) return false;
  const auto* circle = std::get_if<storage::LinkPointCircle>(&plan.query->area);
  return circle != nullptr && circle->radius <= kLocalRadius;
}

absl::Status Answer(std::shared_ptr<const SiteGraph> graph, const LinkPointSearchPlan& plan,
                    v1::FindLinkPointsResponse& response) {
  ENFILADE_ASSIGN_OR_RETURN(const LinkPointSearchResult result, SearchLinkPoints(std::move(graph), plan));
  for (const FoundLinkPoint& found : result.found) Fill(found, *response.add_found());
  if (result.T_world_center) enfilade::convert::ToProto(*result.T_world_center, *response.mutable_pose_world());
  if (result.radius_m) response.set_radius_m(*result.radius_m);
  response.set_graph_version(result.graph->graph().version());
  return absl::OkStatus();
}

}  // namespace

std::optional<absl::Status> TryFindLinkPoints(const Services& services, const v1::FindLinkPointsRequest& request,
                                              v1::FindLinkPointsResponse& response) {
  const absl::StatusOr<GivenSearch> given = Parse(request);
  if (!given.ok()) return given.status();
  auto graph = services.graphs.FindCurrent(given->site);
  if (graph == nullptr) return std::nullopt;
  const auto plan = PlanLinkPointSearchIn(given->site, *graph, given->search);
  if (!plan.ok()) return plan.status();
  if (!IsLocal(*plan)) return std::nullopt;
  return Answer(std::move(graph), *plan, response);
}

absl::Status FindLinkPoints(const Services& services, const Call& call, const v1::FindLinkPointsRequest& request,
                            v1::FindLinkPointsResponse& response) {
  ENFILADE_ASSIGN_OR_RETURN(const GivenSearch given, Parse(request));
  ENFILADE_ASSIGN_OR_RETURN(auto graph, services.graphs.Get(call.context(), given.site));
  ENFILADE_ASSIGN_OR_RETURN(const LinkPointSearchPlan plan, PlanLinkPointSearchIn(given.site, *graph, given.search));
  return Answer(std::move(graph), plan, response);
}

}  // namespace enfilade::server
