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

// What a path is short in. A leg leads through one map from one link point to another; a real number of any size.
enum class PathCost {
  // The position variance that the passed anchors cause, m^2: each counts the trace of its position covariance, and its
  // yaw variance times the square of `lever_m`.
  kUncertainty,
  kDistance,  // metres, straight within each map
  kHops,      // link points passed
};

struct PathOptions {
  PathCost cost = PathCost::kUncertainty;
  // How far beyond a link point its yaw's error is judged (kUncertainty), m: about the size of a map. The same for all,
  // so that a detour through further link points of a map never seems better than the direct way.
  double lever_m = 10.0;
  // Link points that are closed or blocked at this time are not passed. Unset: all are.
  std::optional<TimeNs> passable_at = {};
  // Not to be passed or entered; slots. Null: none.
  const std::unordered_set<int>* without_link_points = nullptr;
  const std::unordered_set<int>* without_maps = nullptr;
  // Legs (map, link point that it leads to) that no path begins with. Null: none.
  const std::unordered_set<std::int64_t>* without_first_legs = nullptr;
};

// What an anchor, or the pose of the map that a path begins with, costs by PathCost::kUncertainty, m^2.
inline double UncertaintyOf(const Eigen::Matrix3d& covariance, double lever_squared) {
  return covariance(0, 0) + covariance(1, 1) + covariance(2, 2) * lever_squared;
}

// A map and link point as one number, for `without_first_legs`.
inline std::int64_t LegKey(int map, int link_point) {
  return (static_cast<std::int64_t>(map) << 32) | static_cast<std::uint32_t>(link_point);
}

// Where paths begin: in a map, at a place in it or, unset, anywhere in it.
struct PathSource {
  int map = 0;        // slot
  double cost = 0.0;  // that paths begin with
  std::optional<Eigen::Vector2d> position = {};
};

// Where a path ends.
struct PathTarget {
  int map = 0;  // slot
  std::optional<Eigen::Vector2d> position = {};
};

// The best way to one link point.
struct PathLabel {
  double cost = std::numeric_limits<double>::infinity();
  int hops = 0;       // link points passed, this one included
  int previous = -1;  // slot; -1: it is the first
  int map = -1;       // slot of the map that the last leg leads through
  int source = -1;    // index into the sources
};

// Dijkstra 1959 from `sources` over the link points that join maps: labels by link point's slot, those not reached at
// infinite cost. Of equally good ways the one with fewer hops, then with the lesser id before it counts, so that the
// result does not depend on how the snapshot came about. A path does not leave a link point into the map that it came
// from, nor into a source's. With a `target` labels beyond it may not be final.
std::vector<PathLabel> ShortestPaths(const GraphSnapshot& graph, const std::vector<PathSource>& sources,
                                     const PathOptions& options, const std::optional<PathTarget>& target = {});

// A path's link points, in order. Empty: source and target are the same map.
struct Path {
  double cost = 0.0;
  int source = 0;  // index into the sources
  // Slots: leg i leads through maps[i] to link_points[i]; the last map is the target's, so that there is one more of
  // them. The same link point may join two maps twice over: both are kept apart.
  std::vector<int> maps = {};
  std::vector<int> link_points = {};

  friend bool operator==(const Path&, const Path&) = default;
};

// The best end of the labelled paths in the target's map, the last leg included; where a source lies in it, that may be
// the whole path. Empty where no path leads there.
std::optional<Path> BestPath(const GraphSnapshot& graph, const std::vector<PathSource>& sources,
                             const std::vector<PathLabel>& labels, const PathTarget& target,
                             const PathOptions& options);

// Both at once.
std::optional<Path> ShortestPath(const GraphSnapshot& graph, const std::vector<PathSource>& sources,
                                 const PathTarget& target, const PathOptions& options);

// What the path costs, whose maps and link points are given.
double CostOf(const GraphSnapshot& graph, const PathSource& source, const Path& path, const PathTarget& target,
              const PathOptions& options);

}  // namespace enfilade::graph
