// SPDX-License-Identifier: Apache-2.0
#include "core/graph/solve/extend_solution.h"

#include <algorithm>
#include <unordered_set>
#include <utility>
#include <vector>

#include "core/graph/joint_graph.h"
#include "core/graph/paths/pose_chain.h"

namespace enfilade::graph {
namespace {

// Whether an optimisation depends on the link point.
bool IsMeasurement(const LinkPoint& link_point) {
  return !link_point.is_candidate() && link_point.use != LinkPointUse::kSuspended;
}

bool IsSameMeasurement(const LinkPoint& a, const LinkPoint& b) {
  return a.id == b.id && a.anchors == b.anchors && IsMeasurement(a) == IsMeasurement(b);
}

const LinkPoint* LinkPointAt(const GraphSnapshot& graph, std::size_t slot) {
  return slot < graph.link_point_slots() ? graph.link_point_node(static_cast<int>(slot)).link_point.get() : nullptr;
}

// The slots of the measurements that `graph` has and `solved` has not. Unset if it lacks one of those of `solved`.
std::optional<std::vector<int>> AddedMeasurements(const GraphSnapshot& solved, const GraphSnapshot& graph) {
  std::vector<int> added;
  const std::size_t slots = std::max(solved.link_point_slots(), graph.link_point_slots());
  for (std::size_t slot = 0; slot < slots; ++slot) {
    const LinkPoint* before = LinkPointAt(solved, slot);
    const LinkPoint* after = LinkPointAt(graph, slot);
    if (before == after) continue;  // versions share what has not changed
    if (before != nullptr && after != nullptr && IsSameMeasurement(*before, *after)) continue;
    if (before != nullptr && IsMeasurement(*before)) return std::nullopt;
    if (after != nullptr && IsMeasurement(*after)) added.push_back(static_cast<int>(slot));
  }
  return added;
}

bool HasAllMaps(const GraphSnapshot& graph, const SolvedGraph& solution) {
  return std::all_of(solution.map_poses.begin(), solution.map_poses.end(),
                     [&](const auto& entry) { return graph.MapSlot(entry.first) >= 0; });
}

// The maps that link points lead to from those that are posed, with their poses.
class Extension {
 public:
  Extension(const GraphSnapshot& graph, SolvedGraph solution, const GraphOptimizationOptions& options)
      : graph_(graph), solution_(std::move(solution)), options_(options) {}

  // False if a map is reached in two ways, or by a link point that must be judged.
  bool Reach(const std::vector<int>& link_points) {
    for (const int link_point : link_points) {
      if (!IsPlain(link_point)) return false;
    }
    // Those between maps that are not posed wait until one of their maps is.
    for (const int link_point : link_points) {
      if (CountPosed(link_point) > 0 && !Pass(link_point)) return false;
    }
    for (std::size_t i = 0; i < reached_.size(); ++i) {
      for (const int link_point : graph_.map_node(reached_[i]).link_points) {
        if (!IsMeasurement(*graph_.link_point_node(link_point).link_point) || passed_.contains(link_point)) continue;
        if (!IsPlain(link_point) || !Pass(link_point)) return false;
      }
    }
    return true;
  }

  SolvedGraph Finish() && {
    solution_.graph_version = graph_.version();
    solution_.iterations = 0;
    solution_.disconnected.clear();
    for (const MapInGraph* map : graph_.ListMaps()) {
      if (!IsPosed(map->id)) solution_.disconnected.push_back(map->id);
    }
    return std::move(solution_);
  }

 private:
  bool IsPosed(const MapId& map) const { return solution_.map_poses.contains(map); }
  bool IsPlain(int link_point) const {
    const LinkPoint& point = *graph_.link_point_node(link_point).link_point;
    return point.anchors.size() == 2 && point.use == LinkPointUse::kUsed && !IsUnusable(point);
  }
  std::ptrdiff_t CountPosed(int link_point) const {
    const std::vector<Anchor>& anchors = graph_.link_point_node(link_point).link_point->anchors;
    return std::count_if(anchors.begin(), anchors.end(), [&](const Anchor& anchor) { return IsPosed(anchor.map); });
  }

  // Poses the map behind the link point; false if it is posed.
  bool Pass(int link_point) {
    passed_.insert(link_point);
    if (CountPosed(link_point) != 1) return false;
    const std::vector<Anchor>& anchors = graph_.link_point_node(link_point).link_point->anchors;
    const bool from_first = IsPosed(anchors[0].map);
    const Anchor& from = anchors[from_first ? 0 : 1];
    const Anchor& to = anchors[from_first ? 1 : 0];
    PoseWithCovariance T_from_to = TransformAcross(from, to);
    const double position = options_.position_floor_m * options_.position_floor_m;
    T_from_to.covariance.diagonal() +=
        Eigen::Vector3d(position, position, options_.yaw_floor_rad * options_.yaw_floor_rad);
    solution_.map_poses[to.map] = Compose(solution_.map_poses.at(from.map), T_from_to);
    reached_.push_back(graph_.MapSlot(to.map));
    return true;
  }

  const GraphSnapshot& graph_;
  SolvedGraph solution_;
  const GraphOptimizationOptions& options_;
  std::vector<int> reached_;        // maps, by slot
  std::unordered_set<int> passed_;  // link points, by slot
};

}  // namespace

std::optional<SolvedGraph> ExtendSolution(const GraphSnapshot& solved, const SolvedGraph& solution,
                                          const GraphSnapshot& graph, const GraphOptimizationOptions& options) {
  if (graph.root() != solution.root || graph.plans() != solved.plans() || !HasAllMaps(graph, solution)) {
    return std::nullopt;
  }
  const std::optional<std::vector<int>> added = AddedMeasurements(solved, graph);
  if (!added) return std::nullopt;
  Extension extension(graph, solution, options);
  if (!extension.Reach(*added)) return std::nullopt;
  return std::move(extension).Finish();
}

}  // namespace enfilade::graph
