// SPDX-License-Identifier: Apache-2.0
#include "core/graph/solve/compare_solutions.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "core/base/status_macros.h"
#include "core/graph/chi_squared.h"
#include "core/graph/joint_graph.h"

namespace enfilade::graph {
namespace {

std::optional<PoseWithCovariance> PoseIn(const SolvedGraph& solution, const MapId& map) {
  const auto found = solution.map_poses.find(map);
  return found == solution.map_poses.end() ? std::nullopt : std::optional(found->second);
}

// m; infinite if one of the solutions does not pose the map.
double DistanceMoved(const MovedMap& moved) {
  if (!moved.T_world_map_before || !moved.T_world_map_after) return std::numeric_limits<double>::infinity();
  return Between(moved.T_world_map_before->pose, moved.T_world_map_after->pose).translation().norm();
}

bool HasMoved(const MovedMap& moved) {
  if (!moved.T_world_map_before && !moved.T_world_map_after) return false;
  if (DistanceMoved(moved) > kMovedDistance) return true;
  return std::abs(WrapAngle(moved.T_world_map_after->pose.yaw - moved.T_world_map_before->pose.yaw)) > kMovedYaw;
}

std::vector<MovedMap> MovedMaps(const SolvedGraph& before, const SolvedGraph& after) {
  std::set<MapId> maps;
  for (const auto& [map, pose] : before.map_poses) maps.insert(map);
  for (const auto& [map, pose] : after.map_poses) maps.insert(map);
  std::vector<MovedMap> all;
  for (const MapId& map : maps) {
    MovedMap moved{map, PoseIn(before, map), PoseIn(after, map)};
    if (HasMoved(moved)) all.push_back(std::move(moved));
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const MovedMap& a, const MovedMap& b) { return DistanceMoved(a) > DistanceMoved(b); });
  return all;
}

struct Residual {
  double chi2 = 0.0;
  double gate = 0.0;
  bool switched_off = false;
};

// Of those of `link_points` that take part in the solution.
absl::StatusOr<std::map<LinkPointId, Residual>> ResidualsOf(const GraphWithSolution& solved,
                                                            const std::set<LinkPointId>& link_points,
                                                            const GraphOptimizationOptions& options) {
  std::map<LinkPointId, Residual> residuals;
  // The joint graph of the graph with its solution has the solved poses.
  ENFILADE_ASSIGN_OR_RETURN(const GraphSnapshot graph,
                            Apply(solved.graph, {.version = solved.graph.version(), .solution = solved.solution}));
  const JointGraph joint = BuildJointGraph(graph, graph.MapSlot(graph.root()), options);
  for (const JointTerm& term : joint.terms) {
    const LinkPoint& link_point = *graph.link_point_node(term.link_point).link_point;
    if (!link_points.contains(link_point.id)) continue;
    Residual& residual = residuals[link_point.id];
    ENFILADE_ASSIGN_OR_RETURN(residual.chi2, Disagreement(joint, joint.graph.nodes, term));
    residual.gate = ChiSquaredQuantile(options.gate_probability, term.degrees_of_freedom);
  }
  for (const SwitchedOff& off : solved.solution->switched_off) residuals[off.link_point].switched_off = true;
  return residuals;
}

}  // namespace

absl::StatusOr<SolutionDifference> CompareSolutions(const GraphWithSolution& before, const GraphWithSolution& after,
                                                    const std::vector<LinkPointId>& asked,
                                                    const GraphOptimizationOptions& options) {
  SolutionDifference difference;
  difference.moved = MovedMaps(*before.solution, *after.solution);
  std::set<LinkPointId> link_points(asked.begin(), asked.end());
  for (const SwitchedOff& off : before.solution->switched_off) link_points.insert(off.link_point);
  for (const SwitchedOff& off : after.solution->switched_off) link_points.insert(off.link_point);
  ENFILADE_ASSIGN_OR_RETURN(auto residuals_before, ResidualsOf(before, link_points, options));
  ENFILADE_ASSIGN_OR_RETURN(auto residuals_after, ResidualsOf(after, link_points, options));
  for (const LinkPointId& id : link_points) {
    const Residual& old = residuals_before[id];
    const Residual& now = residuals_after[id];
    difference.residuals.push_back(
        {id, old.chi2, now.chi2, std::max(old.gate, now.gate), old.switched_off, now.switched_off});
  }
  return difference;
}

}  // namespace enfilade::graph
