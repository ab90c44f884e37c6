// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <unordered_set>
#include <utility>
#include <vector>

#include "core/base/time.h"
#include "core/graph/graph_snapshot.h"

namespace enfilade::graph {

// The cost that a path minimises. A leg crosses one map from one link point to another.
enum class PathCost {
  // The position variance caused by the passed anchors, m^2: for each the trace of its position covariance plus its yaw
  // variance times the square of `lever_m`.
  kUncertainty,
  kDistance,  // metres, straight within each map
  kHops,      // link points passed
};

struct PathOptions {
  PathCost cost = PathCost::kUncertainty;
  // The distance beyond a link point at which its yaw error counts (kUncertainty), m: about the size of a map. Equal
  // for all, so that a detour through other link points of a map never seems better than the direct way.
  double lever_m = 10.0;
  // Link points that are closed or blocked at this time are not passed. Unset: all are passable.
  std::optional<TimeNs> passable_at = {};
  // Slots not to pass or enter. Null: none.
  const std::unordered_set<int>* without_link_points = nullptr;
  const std::unordered_set<int>* without_maps = nullptr;
  // Legs (map, link point at its end) with which no path starts. Null: none.
  const std::unordered_set<std::int64_t>* without_first_legs = nullptr;
};

// The cost of an anchor, or of the pose of a path's first map, by PathCost::kUncertainty, m^2.
inline double UncertaintyOf(const Eigen::Matrix3d& covariance, double lever_squared) {
  return covariance(0, 0) + covariance(1, 1) + covariance(2, 2) * lever_squared;
}

// A map and link point as one number, for `without_first_legs`.
inline std::int64_t LegKey(int map, int link_point) {
  return (static_cast<std::int64_t>(map) << 32) | static_cast<std::uint32_t>(link_point);
}

// The start of paths: a map, and a position in it or, if unset, anywhere in it.
struct PathSource {
  int map = 0;        // slot
  double cost = 0.0;  // initial cost
  std::optional<Eigen::Vector2d> position = {};
};

// The end of a path.
struct PathTarget {
  int map = 0;  // slot
  std::optional<Eigen::Vector2d> position = {};
};

// The best path to one link point.
struct PathLabel {
  double cost = std::numeric_limits<double>::infinity();
  int hops = 0;       // link points passed, including this one
  int previous = -1;  // slot; -1: it is the first
  int map = -1;       // slot of the map that the last leg crosses
  int source = -1;    // index into the sources
};

// Dijkstra's algorithm (1959) from `sources` over the link points that join maps: labels by the slot of the link point,
// with infinite cost if not reached. Ties go to fewer hops, then to the smaller id of the predecessor, so the result
// does not depend on the history of the snapshot. A path does not leave a link point into the map that it came from or
// into a source's map. With `targets`, each in another map, the search ends when it has the best paths to all of them:
// labels beyond them may not be final.
std::vector<PathLabel> ShortestPaths(const GraphSnapshot& graph, const std::vector<PathSource>& sources,
                                     const PathOptions& options, const std::vector<PathTarget>& targets = {});

// A path's link points, in order. Empty: source and target are the same map.
struct Path {
  double cost = 0.0;
  int source = 0;  // index into the sources
  // Slots: leg i crosses maps[i] to link_points[i]. The last map is the target's, so there is one more map than link
  // points.
  std::vector<int> maps = {};
  std::vector<int> link_points = {};

  friend bool operator==(const Path&, const Path&) = default;
};

// The best of the labelled paths to the target, including the last leg. If a source is in the target's map, the path
// has no link points. Empty if no path leads there.
std::optional<Path> BestPath(const GraphSnapshot& graph, const std::vector<PathSource>& sources,
                             const std::vector<PathLabel>& labels, const PathTarget& target,
                             const PathOptions& options);

// ShortestPaths, then BestPath.
std::optional<Path> ShortestPath(const GraphSnapshot& graph, const std::vector<PathSource>& sources,
                                 const PathTarget& target, const PathOptions& options);

// The cost of a path, given its maps and link points.
double CostOf(const GraphSnapshot& graph, const PathSource& source, const Path& path, const PathTarget& target,
              const PathOptions& options);

}  // namespace enfilade::graph
