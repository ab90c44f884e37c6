// SPDX-License-Identifier: Apache-2.0
#include "core/graph/plans/plan_shares.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <string>
#include <utility>

#include "core/base/status_macros.h"
#include "core/optimize/edge_shares.h"

namespace enfilade::graph {
namespace {

using Shares = std::vector<Eigen::Matrix3d>;

// Of part `index`, everything but its ties to others.
std::map<int, Eigen::Matrix3d> SharesByWall(const JointGraph& joint, const PlanPart& part, const Shares& of_edges,
                                            std::int64_t map) {
  std::map<int, Eigen::Matrix3d> by_wall = {{-1, Eigen::Matrix3d::Zero()}};
  for (const std::size_t edge : part.strut_edges) by_wall[-1] += of_edges[edge];
  for (std::size_t i = 0; i < part.edges.size(); ++i) {
    const std::size_t edge = part.edges[i];
    if (edge == PlanPart::kNone || !joint.graph.edges[edge].enabled) continue;
    const bool is_own = joint.graph.edges[edge].from == map;
    const int strut = part.ties().sightings[i].strut;
    const int wall = is_own ? part.ties().struts[static_cast<std::size_t>(strut)].wall : -1;
    by_wall.try_emplace(wall, Eigen::Matrix3d::Zero()).first->second += of_edges[edge];
  }
  return by_wall;
}

// Ties of part `index` to plans of higher levels, by name.
std::map<std::string, Eigen::Matrix3d> SharesByShaft(const JointShafts& shafts, std::size_t index,
                                                     const Shares& of_edges) {
  std::map<std::string, Eigen::Matrix3d> by_shaft;
  for (const ShaftTie& tie : shafts.ties) {
    if (shafts.nodes[tie.a].part != index) continue;
    by_shaft.try_emplace(tie.name, Eigen::Matrix3d::Zero()).first->second += of_edges[tie.edge];
  }
  return by_shaft;
}

}  // namespace

absl::StatusOr<std::vector<PlanShare>> SharesOf(const JointGraph& joint, const std::vector<PlanPart>& parts,
                                                const JointShafts& shafts, std::size_t node) {
  const std::int64_t map = joint.graph.nodes[node].id;
  ENFILADE_ASSIGN_OR_RETURN(const Shares of_edges,
                            optimize::EdgeShares(joint.graph, {joint.graph.nodes.front().id}, map));
  std::vector<PlanShare> shares;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    std::map<int, Eigen::Matrix3d> by_wall = SharesByWall(joint, parts[i], of_edges, map);
    for (const ShaftNode& shaft : shafts.nodes) {
      if (shaft.part != i) continue;
      for (const std::size_t edge : shaft.edges) by_wall[-1] += of_edges[edge];
    }
    const PriorMapId& plan = parts[i].plan->id;
    for (const auto& [wall, share] : by_wall) shares.push_back({.plan = plan, .wall = wall, .share = share});
    for (const auto& [name, share] : SharesByShaft(shafts, i, of_edges)) {
      shares.push_back({.plan = plan, .shaft = name, .share = share});
    }
  }
  std::stable_sort(shares.begin(), shares.end(),
                   [](const PlanShare& a, const PlanShare& b) { return a.plan < b.plan; });
  return shares;
}

}  // namespace enfilade::graph
