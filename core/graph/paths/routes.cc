// SPDX-License-Identifier: Apache-2.0
#include "core/graph/paths/routes.h"

#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/graph/paths/k_shortest_paths.h"

namespace enfilade::graph {
namespace {

Route RouteAlong(const GraphSnapshot& graph, const Path& path, const RouteRequest& request) {
  Route route{.legs = {}, .length_m = 0.0, .cost = path.cost};
  Pose2 T_map_begin = request.T_from_map_start;
  for (std::size_t i = 0; i < path.maps.size(); ++i) {
    const MapInGraph& map = *graph.map_node(path.maps[i]).map;
    RouteLeg leg{.map = map.id, .level = map.level, .T_map_begin = T_map_begin, .T_map_end = request.T_to_map_goal};
    if (i < path.link_points.size()) {
      const LinkPoint& exit = *graph.link_point_node(path.link_points[i]).link_point;
      leg.exit = exit.id;
      leg.T_map_end = exit.FindAnchor(map.id)->T_map_place;
      T_map_begin = exit.FindAnchor(graph.map_node(path.maps[i + 1]).map->id)->T_map_place;
    }
    leg.length_m = (leg.T_map_end.translation() - leg.T_map_begin.translation()).norm();
    route.length_m += leg.length_m;
    route.legs.push_back(std::move(leg));
  }
  return route;
}

}  // namespace

absl::StatusOr<Routes> FindRoutes(const GraphSnapshot& graph, const RouteRequest& request,
                                  const RouteOptions& options) {
  if (!IsFinite(request.T_from_map_start)) return InvalidArgument("the start is not finite");
  if (!IsFinite(request.T_to_map_goal)) return InvalidArgument("the goal is not finite");
  if (options.max_routes < 1) return InvalidArgument("max_routes is {}: it must be at least 1", options.max_routes);
  const int from = graph.MapSlot(request.from_map);
  const int to = graph.MapSlot(request.to_map);
  for (const auto& [slot, map] : {std::pair(from, request.from_map), std::pair(to, request.to_map)}) {
    if (slot < 0) return NotFound("the graph has no map {} at version {}", map.value(), graph.version());
  }
  const PathOptions path_options{.cost = options.cost, .lever_m = options.lever_m, .passable_at = options.time};
  Routes result{.graph_version = graph.version(), .routes = {}};
  for (const Path& path :
       KShortestPaths(graph, {.map = from, .cost = 0.0, .position = request.T_from_map_start.translation()},
                      {.map = to, .position = request.T_to_map_goal.translation()}, path_options, options.max_routes)) {
    result.routes.push_back(RouteAlong(graph, path, request));
  }
  return result;
}

}  // namespace enfilade::graph
