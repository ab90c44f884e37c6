// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/base/time.h"
#include "core/geometry/pose2.h"
#include "core/graph/graph_snapshot.h"
#include "core/graph/paths/shortest_paths.h"

namespace enfilade::graph {

struct RouteRequest {
  MapId from_map;
  Pose2 T_from_map_start;
  MapId to_map;
  Pose2 T_to_map_goal;
};

struct RouteOptions {
  PathCost cost = PathCost::kDistance;
  double lever_m = 10.0;  // see PathOptions
  // Link points that are closed or blocked at this time are not passed.
  TimeNs time = 0;
  // The maximum number of routes, at least 1.
  int max_routes = 1;
};

// The part of a route in one map, in that map's frame.
struct RouteLeg {
  MapId map = {};
  int level = 0;
  Pose2 T_map_begin = {};  // the start, or the place of the link point behind
  Pose2 T_map_end = {};    // the place of the link point ahead, or the goal
  double length_m = 0.0;   // straight
  LinkPointId exit = {};   // the link point ahead; empty on the last leg
};

struct Route {
  std::vector<RouteLeg> legs = {};  // at least one
  double length_m = 0.0;            // of all legs
  double cost = 0.0;                // in the unit of the PathCost
};

struct Routes {
  std::int64_t graph_version = 0;
  std::vector<Route> routes = {};  // best first; empty: there is no way
};

// The best routes from a pose in one map to a pose in another that visit no map or link point twice (Yen 1971: the k
// shortest loopless paths). NOT_FOUND: no such map.
// INVALID_ARGUMENT: a pose is not finite, max_routes below 1.
absl::StatusOr<Routes> FindRoutes(const GraphSnapshot& graph, const RouteRequest& request, const RouteOptions& options);

}  // namespace enfilade::graph
