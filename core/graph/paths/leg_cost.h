// SPDX-License-Identifier: Apache-2.0
#pragma once

// The costs of legs by PathCost; for the searches in this folder only.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "core/graph/graph_snapshot.h"
#include "core/graph/paths/shortest_paths.h"

namespace enfilade::graph {

// The cost between `position`, or anywhere in the map if unset, and the link point at the doorway.
template <PathCost kCost>
double EndCost(const std::optional<Eigen::Vector2d>& position, const GraphSnapshot::Doorway& doorway,
               double lever_squared) {
  if constexpr (kCost == PathCost::kUncertainty) {
    return doorway.position_spread + doorway.yaw_variance * lever_squared;
  } else if constexpr (kCost == PathCost::kDistance) {
    return position.has_value() ? std::hypot(position->x() - doorway.x, position->y() - doorway.y) : 0.0;
  } else {
    return 0.0;
  }
}

// The same by the anchor's covariance, for costs whose legs are sums.
template <PathCost kCost>
double EndCost(const Eigen::Matrix3d& covariance, double lever_squared) {
  if constexpr (kCost == PathCost::kUncertainty) {
    return UncertaintyOf(covariance, lever_squared);
  } else {
    return 0.0;
  }
}

// Whether a leg costs the sum of the costs of its two ends.
template <PathCost kCost>
constexpr bool kLegsAreSums = kCost != PathCost::kDistance;

// The cost of a path after crossing a map from one doorway to another; `cost` is its cost before.
template <PathCost kCost>
double CostAcross(double cost, const GraphSnapshot::Doorway& from, const GraphSnapshot::Doorway& to,
                  double lever_squared) {
  if constexpr (kLegsAreSums<kCost>) {
    // In this order: then a path that enters a map more cheaply reaches no doorway at a higher cost, even with
    // rounding.
    return cost + EndCost<kCost>({}, from, lever_squared) + EndCost<kCost>({}, to, lever_squared) +
           (kCost == PathCost::kHops ? 1.0 : 0.0);
  } else {
    const double dx = to.x - from.x;
    const double dy = to.y - from.y;
    return cost + std::sqrt(dx * dx + dy * dy);
  }
}

// The cost of the first leg.
template <PathCost kCost>
double FirstLegCost(const PathSource& source, const GraphSnapshot::Doorway& doorway, double lever_squared) {
  return source.cost + EndCost<kCost>(source.position, doorway, lever_squared) + (kCost == PathCost::kHops ? 1.0 : 0.0);
}

inline const GraphSnapshot::Doorway& DoorwayOf(const GraphSnapshot& graph, int map, int link_point) {
  const std::vector<GraphSnapshot::Doorway>& doorways = graph.map_node(map).doorways;
  return *std::find_if(doorways.begin(), doorways.end(), [link_point](const GraphSnapshot::Doorway& doorway) {
    return doorway.link_point == link_point;
  });
}

// The cost of the last leg, where the lever of the yaw is known.
template <PathCost kCost>
double LastLegCost(const PathTarget& target, const GraphSnapshot::Doorway& doorway, const PathOptions& options) {
  const double lever_squared = target.position.has_value()
                                   ? (*target.position - Eigen::Vector2d(doorway.x, doorway.y)).squaredNorm()
                                   : options.lever_m * options.lever_m;
  return EndCost<kCost>(target.position, doorway, lever_squared);
}

}  // namespace enfilade::graph
