// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/geometry/pose2.h"
#include "core/graph/graph_snapshot.h"
#include "core/graph/paths/pose_chain.h"
#include "core/graph/paths/shortest_paths.h"

namespace enfilade::graph {

// A pose in the world frame, and why it is so.
struct GlobalPose {
  PoseWithCovariance T_world_robot = {};
  std::int64_t graph_version = 0;
  // The map that the chain begins in: the root, or one that the solution has posed.
  MapId base_map = {};
  PoseWithCovariance T_world_base = {};
  // The graph version of the optimisation that T_world_base comes from; unset: base_map is the root, nothing optimised.
  std::optional<std::int64_t> solution_version = {};
  // base_share + the hops' shares + robot_share = the covariance of T_world_robot.
  Eigen::Matrix3d base_share = Eigen::Matrix3d::Zero();
  std::vector<PoseHop> hops = {};
  Eigen::Matrix3d robot_share = Eigen::Matrix3d::Zero();
};

// Answers from one snapshot. A map that the solution poses is answered at once; the first one that it does not pose
// costs one search over the whole graph. May be asked by several threads at once.
//
// Where an optimised solution exists, T_world_map comes from it. A map that it does not pose (made since) is chained
// from the solved map from which the path is best, that map's own uncertainty counted: T_world_robot = T_world_base *
// hops * T_map_robot. The base's covariance and the hops' are independent: a link point that leads out of the solved
// maps was no part of the solution. Without a solution the base is the root, exactly at the origin. So an optimisation
// of a tree changes no pose, and no covariance but to the second order: nothing in a tree contradicts anything.
// Chains ignore whether doors are open. Link points switched off or suspended are in no chain; that a solution was made
// with one that is suspended since shows in its version, until the next one.
class WorldPoses {
 public:
  // `options.passable_at` and the exclusions are for routes and not used.
  explicit WorldPoses(GraphSnapshot graph, const PathOptions& options = {});
  WorldPoses(WorldPoses&&) noexcept;
  ~WorldPoses();

  const GraphSnapshot& graph() const { return graph_; }

  // Empty where no chain joins the map to the world, which is an answer. NOT_FOUND: no such map.
  absl::StatusOr<std::optional<GlobalPose>> Find(const MapId& map, const PoseWithCovariance& T_map_robot) const;

  // Of a map's origin.
  absl::StatusOr<std::optional<GlobalPose>> Find(const MapId& map) const { return Find(map, {}); }

 private:
  struct Chains;

  std::optional<Path> FindPath(int map, const Pose2& T_map_robot) const;

  GraphSnapshot graph_;
  PathOptions options_;
  std::unique_ptr<Chains> chains_;
};

// T_a_b of two maps, and why.
struct MapTransform {
  PoseWithCovariance T_a_b = {};
  std::int64_t graph_version = 0;
  std::vector<PoseHop> hops = {};
  // Set where the solution poses both maps: the pose then comes from it.
  std::optional<std::int64_t> solution_version = {};
};

// The frame of map b in that of map a. The pose is the solution's where it has both maps, and that of the chain
// otherwise; the covariance is the chain's in both cases. (An optimisation only adds to what the chain knows, so that
// its covariance is no less than the optimised one, whose correlations between maps are not kept.) Empty where no chain
// joins the maps. NOT_FOUND: no such map.
absl::StatusOr<std::optional<MapTransform>> FindTransform(const GraphSnapshot& graph, const MapId& a, const MapId& b,
                                                          const PathOptions& options = {});

// The frame of map b in those of any number of other maps, as FindTransform has it: one search for all of them.
class TransformsTo {
 public:
  // `graph` must outlive it. NOT_FOUND: no such map.
  static absl::StatusOr<TransformsTo> Make(const GraphSnapshot& graph, const MapId& b, const PathOptions& options = {});

  absl::StatusOr<std::optional<MapTransform>> Find(const MapId& a) const;

 private:
  TransformsTo(const GraphSnapshot& graph, int b, const PathOptions& options);

  const GraphSnapshot* graph_;
  PathOptions options_;
  std::vector<PathSource> sources_;
  std::vector<PathLabel> labels_;
};

// The poses, given in map b, in the frame of map a.
std::vector<PoseWithCovariance> TransformPoses(const MapTransform& T_a_b,
                                               const std::vector<PoseWithCovariance>& T_b_poses);

// Where a link point lies in the world: its anchor of the least trace of position covariance there. Empty where none of
// its maps is joined to the world.
std::optional<PoseWithCovariance> FindInWorld(const WorldPoses& poses, const LinkPoint& link_point);

}  // namespace enfilade::graph
