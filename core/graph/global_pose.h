// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/geometry/pose2.h"
#include "core/graph/graph_snapshot.h"
#include "core/graph/paths/pose_chain.h"
#include "core/graph/paths/shortest_paths.h"

namespace enfilade::graph {

// What a plan in use contributes to a pose.
struct PlanHop {
  PriorMapId plan;
  int wall = -1;           // as PlanShare::wall
  std::string shaft = {};  // as PlanShare::shaft
  Eigen::Matrix3d share = Eigen::Matrix3d::Zero();
};

// A pose in the world frame, with its derivation.
struct GlobalPose {
  PoseWithCovariance T_world_robot = {};
  std::int64_t graph_version = 0;
  // The map in which the chain starts: the root, or a map posed by the solution.
  MapId base_map = {};
  PoseWithCovariance T_world_base = {};
  // The graph version of the optimisation that gave T_world_base; unset: no optimisation, base_map is the root.
  std::optional<std::int64_t> solution_version = {};
  // base_share + the shares of plan_hops and hops + robot_share = the covariance of T_world_robot.
  Eigen::Matrix3d base_share = Eigen::Matrix3d::Zero();
  std::vector<PoseHop> hops = {};
  Eigen::Matrix3d robot_share = Eigen::Matrix3d::Zero();
  // Plans in use of which the base map has seen walls: they are part of what gave T_world_base.
  std::vector<PriorMapId> plans = {};
  // Of these plans, if ExplainPlans was called; else they are part of base_share.
  std::vector<PlanHop> plan_hops = {};
};

// World poses from one snapshot. Maps posed by the solution need no search; the first other map costs one search over
// the whole graph. Thread-safe.
//
// If there is an optimised solution, T_world_map comes from it. A map that it does not pose (created later) is chained
// from the solved map with the best path, including that map's own uncertainty: T_world_robot = T_world_base * hops *
// T_map_robot. The covariances of base and hops are independent: a link point that leads out of the solved maps was not
// part of the solution. Without a solution the base is the root, exactly at the origin. The optimisation of a tree thus
// changes no pose, and covariances only to second order: a tree has no contradictions. Chains ignore whether doors are
// open and never use switched-off or suspended link points. If a link point was suspended after the solution was made,
// the solution's version shows it until the next optimisation.
class WorldPoses {
 public:
  // Ignores `options.passable_at` and the exclusions, which are for routes.
  explicit WorldPoses(GraphSnapshot graph, const PathOptions& options = {});
  WorldPoses(WorldPoses&&) noexcept;
  ~WorldPoses();

  const GraphSnapshot& graph() const { return graph_; }

  // Empty, not an error, if no chain connects the map to the world. NOT_FOUND: no such map.
  absl::StatusOr<std::optional<GlobalPose>> Find(const MapId& map, const PoseWithCovariance& T_map_robot) const;

  // The pose of a map's origin.
  absl::StatusOr<std::optional<GlobalPose>> Find(const MapId& map) const { return Find(map, {}); }

 private:
  struct Chains;

  std::optional<Path> FindPath(int map, const Pose2& T_map_robot) const;

  GraphSnapshot graph_;
  PathOptions options_;
  std::unique_ptr<Chains> chains_;
};

// Splits what plans contribute from pose.base_share: one hop for each wall that the base map has seen, one for each
// shaft that ties plans of different levels, and one for everything else that a plan says. `pose` is by `graph`. Takes
// an optimisation, if plans are part of the pose. Errors of OptimizeGraph.
absl::Status ExplainPlans(const GraphSnapshot& graph, GlobalPose& pose);

// T_a_b of two maps, with its derivation.
struct MapTransform {
  PoseWithCovariance T_a_b = {};
  std::int64_t graph_version = 0;
  std::vector<PoseHop> hops = {};
  // Set if the solution poses both maps and so gave the pose.
  std::optional<std::int64_t> solution_version = {};
};

// The frame of map b in map a. The pose is the solution's if it has both maps, otherwise the chain's; the covariance is
// always the chain's. (Correlations between solved maps are not stored. The chain's covariance is an upper bound,
// because an optimisation uses at least the chain's information.) Where no chain connects two maps that the solution
// poses, only a plan does: then both are the solution's, the covariance as if the two poses were independent. Empty if
// nothing connects the maps. NOT_FOUND: no such map.
absl::StatusOr<std::optional<MapTransform>> FindTransform(const GraphSnapshot& graph, const MapId& a, const MapId& b,
                                                          const PathOptions& options = {});

// FindTransform from any number of maps a to one map b. Maps that are not expected: the first few take a search each,
// which ends at a; then one search serves all. Not thread-safe.
class TransformsTo {
 public:
  // `graph` must outlive the result. NOT_FOUND: no such map.
  static absl::StatusOr<TransformsTo> Make(const GraphSnapshot& graph, const MapId& b, const PathOptions& options = {});

  // Find will be called for these maps, which one search then serves that ends when it has reached them all.
  // NOT_FOUND: no such map.
  absl::Status Expect(const std::vector<MapId>& maps);

  absl::StatusOr<std::optional<MapTransform>> Find(const MapId& a);

 private:
  TransformsTo(const GraphSnapshot& graph, int b, const PathOptions& options);

  const GraphSnapshot* graph_;
  PathOptions options_;
  std::vector<PathSource> sources_;
  int searches_ = 0;
  std::vector<PathLabel> labels_;  // of the search that serves all, or all of expected_; empty: not made yet
  std::set<int> expected_;         // slots; empty: labels_ serves all
};

// Transforms poses from map b to map a.
std::vector<PoseWithCovariance> TransformPoses(const MapTransform& T_a_b,
                                               const std::vector<PoseWithCovariance>& T_b_poses);

// The pose of a link point in the world, by the anchor with the smallest trace of position covariance there. Empty if
// none of its maps is connected to the world.
std::optional<PoseWithCovariance> FindInWorld(const WorldPoses& poses, const LinkPoint& link_point);

}  // namespace enfilade::graph
