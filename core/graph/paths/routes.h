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
  // Link points that are closed or blocked then are not passed.
  TimeNs time = 0;
  // How many routes at most; from 1.
  int max_routes = 1;
};

// One map on the way. Poses are in its frame: what a robot navigates by while it is in it.
struct RouteLeg {
  MapId map = {};
  int level = 0;
  Pose2 T_map_begin = {};  // the start, or the place of the link point that it came through
  Pose2 T_map_end = {};    // the place of the link point ahead, or the goal
  double length_m = 0.0;   // straight
  LinkPointId exit = {};   // the link point ahead; empty on the last leg
};

struct Route {
  std::vector<RouteLeg> legs = {};  // one at least
  double length_m = 0.0;            // of all legs
  double cost = 0.0;                // in the unit of the PathCost
};

struct Routes {
  std::int64_t graph_version = 0;
  std::vector<Route> routes = {};  // the best first; none: no way leads there
};

// The best ways from a pose in one map to a pose in another, none of which enters a map or passes a link point twice
// (Yen 1971, the k shortest loopless paths, with maps counted among what must not repeat). NOT_FOUND: no such map.
// INVALID_ARGUMENT: a pose is not finite, max_routes below 1.
absl::StatusOr<Routes> FindRoutes(const GraphSnapshot& graph, const RouteRequest& request, const RouteOptions& options);

}  // namespace enfilade::graph
