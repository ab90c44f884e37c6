// SPDX-License-Identifier: Apache-2.0
#include "core/graph/global_pose.h"

#include <algorithm>
#include <utility>

#include "absl/base/call_once.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/graph/graph_optimization.h"

namespace enfilade::graph {
namespace {

constexpr int kSearchesEach = 8;  // before one search serves all

absl::StatusOr<int> GetMapSlot(const GraphSnapshot& graph, const MapId& map) {
  const int slot = graph.MapSlot(map);
  if (slot < 0) return NotFound("the graph has no map {} at version {}", map.value(), graph.version());
  return slot;
}

// Whether the map's world pose is known without a chain.
bool IsPosed(const GraphSnapshot& graph, const MapId& map) {
  return map == graph.root() || graph.FindSolvedPose(map) != nullptr;
}

// The initial cost of paths from a map with this pose covariance.
double InitialCost(const Eigen::Matrix3d& covariance, const PathOptions& options) {
  if (options.cost != PathCost::kUncertainty) return 0.0;
  return UncertaintyOf(covariance, options.lever_m * options.lever_m);
}

std::vector<PathSource> SolvedMaps(const GraphSnapshot& graph, const PathOptions& options) {
  std::vector<PathSource> sources;
  if (const int root = graph.MapSlot(graph.root()); root >= 0) {
    sources.push_back({.map = root, .cost = 0.0, .position = Eigen::Vector2d::Zero()});
  }
  if (graph.solution() == nullptr || graph.solution()->root != graph.root()) return sources;
  for (const auto& [map, T_world_map] : graph.solution()->map_poses) {
    const int slot = graph.MapSlot(map);
    if (slot < 0 || map == graph.root()) continue;
    sources.push_back({.map = slot, .cost = InitialCost(T_world_map.covariance, options), .position = std::nullopt});
  }
  // Sorted by id, because the result must not depend on the order of the hash map or of the slots.
  std::sort(sources.begin(), sources.end(), [&graph](const PathSource& a, const PathSource& b) {
    return graph.map_node(a.map).map->id < graph.map_node(b.map).map->id;
  });
  return sources;
}

// By the solution alone. Empty if it does not pose both.
std::optional<MapTransform> TransformBySolution(const GraphSnapshot& graph, int a, int b) {
  const PoseWithCovariance* T_world_a = graph.FindSolvedPose(graph.map_node(a).map->id);
  const PoseWithCovariance* T_world_b = graph.FindSolvedPose(graph.map_node(b).map->id);
  if (T_world_a == nullptr || T_world_b == nullptr) return std::nullopt;
  return MapTransform{.T_a_b = Compose(Inverse(*T_world_a), *T_world_b),
                      .graph_version = graph.version(),
                      .hops = {},
                      .solution_version = graph.solution()->graph_version};
}

MapTransform TransformAlong(const GraphSnapshot& graph, const Path& path) {
  PoseChain chain = ChainAlong(graph, path, {}, {});
  MapTransform result{.T_a_b = chain.T_start_end,
                      .graph_version = graph.version(),
                      .hops = std::move(chain.hops),
                      .solution_version = std::nullopt};
  const PoseWithCovariance* T_world_a = graph.FindSolvedPose(graph.map_node(path.maps.front()).map->id);
  const PoseWithCovariance* T_world_b = graph.FindSolvedPose(graph.map_node(path.maps.back()).map->id);
  if (T_world_a != nullptr && T_world_b != nullptr) {
    result.T_a_b.pose = Between(T_world_a->pose, T_world_b->pose);
    result.solution_version = graph.solution()->graph_version;
  }
  return result;
}

}  // namespace

// Paths from the posed maps to all others, computed on first use.
struct WorldPoses::Chains {
  absl::once_flag once;
  std::vector<PathSource> sources;
  std::vector<PathLabel> labels;
};

WorldPoses::WorldPoses(GraphSnapshot graph, const PathOptions& options)
    : graph_(std::move(graph)),
      options_{.cost = options.cost, .lever_m = options.lever_m},
      chains_(std::make_unique<Chains>()) {}

WorldPoses::WorldPoses(WorldPoses&&) noexcept = default;
WorldPoses::~WorldPoses() = default;

std::optional<Path> WorldPoses::FindPath(int map, const Pose2& T_map_robot) const {
  if (IsPosed(graph_, graph_.map_node(map).map->id)) {
    return Path{.cost = 0.0, .source = 0, .maps = {map}, .link_points = {}};
  }
  absl::call_once(chains_->once, [this] {
    chains_->sources = SolvedMaps(graph_, options_);
    chains_->labels = ShortestPaths(graph_, chains_->sources, options_);
  });
  const PathTarget target{.map = map, .position = T_map_robot.translation()};
  return BestPath(graph_, chains_->sources, chains_->labels, target, options_);
}

absl::StatusOr<std::optional<GlobalPose>> WorldPoses::Find(const MapId& map,
                                                           const PoseWithCovariance& T_map_robot) const {
  ENFILADE_ASSIGN_OR_RETURN(const int slot, GetMapSlot(graph_, map));
  const std::optional<Path> path = FindPath(slot, T_map_robot.pose);
  if (!path.has_value()) return std::optional<GlobalPose>();

  GlobalPose result{.graph_version = graph_.version(), .base_map = graph_.map_node(path->maps.front()).map->id};
  if (const PoseWithCovariance* solved = graph_.FindSolvedPose(result.base_map)) {
    result.T_world_base = *solved;
    result.solution_version = graph_.solution()->graph_version;
    for (const PlanInGraph& plan : graph_.plans()) {
      if (plan.ties->HasSeen(result.base_map)) result.plans.push_back(plan.id);
    }
  }
  PoseChain chain = ChainAlong(graph_, *path, result.T_world_base, T_map_robot);
  result.T_world_robot = chain.T_start_end;
  result.base_share = chain.start_share;
  result.hops = std::move(chain.hops);
  result.robot_share = chain.end_share;
  return std::optional<GlobalPose>(std::move(result));
}

absl::Status ExplainPlans(const GraphSnapshot& graph, GlobalPose& pose) {
  if (pose.plans.empty()) return absl::OkStatus();
  ENFILADE_ASSIGN_OR_RETURN(const SolvedGraph solution, OptimizeGraph(graph, {.shares_of = pose.base_map}));
  const Pose2 T_base_robot = Between(pose.T_world_base.pose, pose.T_world_robot.pose);
  for (const PlanShare& part : solution.plan_shares) {
    const Eigen::Matrix3d share = Compose({pose.T_world_base.pose, part.share}, {.pose = T_base_robot}).covariance;
    pose.plan_hops.push_back({part.plan, part.wall, part.shaft, share});
    pose.base_share -= share;
  }
  return absl::OkStatus();
}

absl::StatusOr<std::optional<MapTransform>> FindTransform(const GraphSnapshot& graph, const MapId& a, const MapId& b,
                                                          const PathOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(const int slot_a, GetMapSlot(graph, a));
  ENFILADE_ASSIGN_OR_RETURN(const int slot_b, GetMapSlot(graph, b));
  const std::vector<PathSource> sources = {{.map = slot_a, .cost = 0.0, .position = std::nullopt}};
  const std::optional<Path> path = ShortestPath(graph, sources, {.map = slot_b, .position = std::nullopt}, options);
  if (!path.has_value()) return TransformBySolution(graph, slot_a, slot_b);
  return std::optional<MapTransform>(TransformAlong(graph, *path));
}

TransformsTo::TransformsTo(const GraphSnapshot& graph, int b, const PathOptions& options)
    : graph_(&graph), options_(options), sources_({{.map = b, .cost = 0.0, .position = std::nullopt}}) {}

absl::StatusOr<TransformsTo> TransformsTo::Make(const GraphSnapshot& graph, const MapId& b,
                                                const PathOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(const int slot, GetMapSlot(graph, b));
  return TransformsTo(graph, slot, options);
}

absl::Status TransformsTo::Expect(const std::vector<MapId>& maps) {
  std::set<int> slots;
  for (const MapId& map : maps) {
    ENFILADE_ASSIGN_OR_RETURN(const int slot, GetMapSlot(*graph_, map));
    if (slot != sources_.front().map) slots.insert(slot);
  }
  const bool all_are_served = !labels_.empty() && expected_.empty();
  if (slots.empty() || all_are_served) return absl::OkStatus();
  std::vector<PathTarget> targets;
  for (const int slot : slots) targets.push_back({.map = slot, .position = std::nullopt});
  labels_ = ShortestPaths(*graph_, sources_, options_, targets);
  expected_ = std::move(slots);
  return absl::OkStatus();
}

absl::StatusOr<std::optional<MapTransform>> TransformsTo::Find(const MapId& a) {
  ENFILADE_ASSIGN_OR_RETURN(const int slot, GetMapSlot(*graph_, a));
  const PathTarget target{.map = slot, .position = std::nullopt};
  std::optional<Path> path;
  const bool is_served = !labels_.empty() && (expected_.empty() || expected_.contains(slot));
  if (!is_served && searches_ < kSearchesEach) {
    ++searches_;
    path = ShortestPath(*graph_, sources_, target, options_);
  } else {
    if (!is_served) {
      labels_ = ShortestPaths(*graph_, sources_, options_);
      expected_.clear();
    }
    path = BestPath(*graph_, sources_, labels_, target, options_);
  }
  if (!path.has_value()) return TransformBySolution(*graph_, slot, sources_.front().map);
  // The search started at b; legs cost the same in both directions.
  std::reverse(path->maps.begin(), path->maps.end());
  std::reverse(path->link_points.begin(), path->link_points.end());
  return std::optional<MapTransform>(TransformAlong(*graph_, *path));
}

std::vector<PoseWithCovariance> TransformPoses(const MapTransform& T_a_b,
                                               const std::vector<PoseWithCovariance>& T_b_poses) {
  std::vector<PoseWithCovariance> poses;
  poses.reserve(T_b_poses.size());
  for (const PoseWithCovariance& T_b_pose : T_b_poses) poses.push_back(Compose(T_a_b.T_a_b, T_b_pose));
  return poses;
}

std::optional<PoseWithCovariance> FindInWorld(const WorldPoses& poses, const LinkPoint& link_point) {
  std::optional<PoseWithCovariance> best;
  const auto spread = [](const PoseWithCovariance& pose) { return pose.covariance(0, 0) + pose.covariance(1, 1); };
  for (const Anchor& anchor : link_point.anchors) {
    const auto found = poses.Find(anchor.map, {anchor.T_map_place, anchor.covariance});
    if (!found.ok() || !found->has_value()) continue;
    const PoseWithCovariance& T_world_place = (*found)->T_world_robot;
    if (!best.has_value() || spread(T_world_place) < spread(*best)) best = T_world_place;
  }
  return best;
}

}  // namespace enfilade::graph
