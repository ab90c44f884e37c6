// SPDX-License-Identifier: Apache-2.0
#include <chrono>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/graph/geojson.h"
#include "proto/convert/names.h"
#include "proto/convert/record.h"
#include "server/rpc/graph/handlers.h"
#include "server/rpc/graph/messages.h"
#include "server/rpc/rearrange/resolve_map.h"

namespace enfilade::server {
namespace {

constexpr int kMaxRoutes = 16;

absl::StatusOr<graph::PathCost> CostOf(v1::PathCost cost) {
  switch (cost) {
    case v1::PATH_COST_UNSPECIFIED:
    case v1::PATH_COST_DISTANCE:
      return graph::PathCost::kDistance;
    case v1::PATH_COST_UNCERTAINTY:
      return graph::PathCost::kUncertainty;
    case v1::PATH_COST_HOPS:
      return graph::PathCost::kHops;
    default:
      return InvalidArgument("cost is {}: expected PATH_COST_DISTANCE, _UNCERTAINTY or _HOPS", static_cast<int>(cost));
  }
}

absl::StatusOr<graph::RouteOptions> OptionsOf(const v1::FindRoutesRequest& request) {
  graph::RouteOptions options;
  ENFILADE_ASSIGN_OR_RETURN(options.cost, CostOf(request.cost()));
  if (request.max_routes() < 0 || request.max_routes() > kMaxRoutes) {
    return InvalidArgument("max_routes is {}: at most {}", request.max_routes(), kMaxRoutes);
  }
  options.max_routes = std::max(request.max_routes(), 1);
  options.time = std::chrono::nanoseconds(std::chrono::system_clock::now().time_since_epoch()).count();
  if (request.has_time()) {
    const absl::StatusOr<TimeNs> time = convert::FromTimestamp(request.time());
    if (!time.ok()) return WithContext(time.status(), "time");
    options.time = *time;
  }
  return options;
}

}  // namespace

absl::StatusOr<v1::FindRoutesResponse> FindRoutes(const Services& services, const Call& call,
                                                  const v1::FindRoutesRequest& request) {
  v1::FindRoutesResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const convert::MapName start, convert::ParseMapName("start_map", request.start_map()));
  ENFILADE_ASSIGN_OR_RETURN(const convert::MapName goal, convert::ParseMapName("goal_map", request.goal_map()));
  if (start.site != goal.site) return InvalidArgument("start_map and goal_map belong to different sites");
  if (!request.has_pose_map_start()) return InvalidArgument("pose_map_start is missing");
  if (!request.has_pose_map_goal()) return InvalidArgument("pose_map_goal is missing");
  ENFILADE_ASSIGN_OR_RETURN(const graph::RouteOptions options, OptionsOf(request));
  ENFILADE_ASSIGN_OR_RETURN(const auto graph, services.graphs.Get(call.context(), start.site));
  ENFILADE_ASSIGN_OR_RETURN(const auto from, ResolveMap(services, call, graph->graph(), start));
  ENFILADE_ASSIGN_OR_RETURN(const auto to, ResolveMap(services, call, graph->graph(), goal));
  ENFILADE_ASSIGN_OR_RETURN(
      const graph::Routes routes,
      enfilade::graph::FindRoutes(graph->graph(),
                                  {from.to, from.T_to_from * enfilade::convert::FromProto(request.pose_map_start()),
                                   to.to, to.T_to_from * enfilade::convert::FromProto(request.pose_map_goal())},
                                  options));
  response.set_graph_version(routes.graph_version);
  for (const graph::Route& route : routes.routes) *response.add_routes() = ToProto(start.site, route);
  if (request.with_geojson()) {
    response.set_geojson(graph::RoutesToGeoJson(
        routes, graph->poses, graph->georeference.has_value() ? &graph->georeference->georeference : nullptr));
  }
  return response;
}

}  // namespace enfilade::server
