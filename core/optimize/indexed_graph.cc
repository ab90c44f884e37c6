// SPDX-License-Identifier: Apache-2.0
#include "core/optimize/indexed_graph.h"

#include <algorithm>
#include <unordered_map>

#include "core/base/disjoint_sets.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/optimize/information.h"

namespace enfilade::optimize {
namespace {

using NodeIndex = std::unordered_map<std::int64_t, int>;

absl::StatusOr<NodeIndex> IndexNodes(const PoseGraph& graph) {
  NodeIndex index;
  index.reserve(graph.nodes.size());
  for (const PoseGraphNode& node : graph.nodes) {
    if (!IsFinite(node.T_world_node))
      return InvalidArgument("pose graph: node {} has a pose that is not finite", node.id);
    if (!index.emplace(node.id, static_cast<int>(index.size())).second) {
      return InvalidArgument("pose graph: node {} appears twice", node.id);
    }
  }
  return index;
}

absl::Status CheckEdge(const PoseGraphEdge& edge, const NodeIndex& index) {
  if (!index.contains(edge.from)) return InvalidArgument("there is no node {}", edge.from);
  if (!index.contains(edge.to)) return InvalidArgument("there is no node {}", edge.to);
  if (edge.from == edge.to) return InvalidArgument("it joins a node with itself");
  if (!IsFinite(edge.T_from_to)) return InvalidArgument("its measurement is not finite");
  return CheckInformation(edge.information);
}

}  // namespace

absl::StatusOr<std::vector<IndexedGraph>> IndexComponents(const PoseGraph& graph,
                                                          const std::vector<std::int64_t>& fixed) {
  ENFILADE_ASSIGN_OR_RETURN(const NodeIndex index, IndexNodes(graph));
  DisjointSets sets(graph.nodes.size());
  for (const PoseGraphEdge& edge : graph.edges) {
    if (absl::Status status = CheckEdge(edge, index); !status.ok()) {
      return WithContext(status, fmt::format("pose graph: edge {} -> {}", edge.from, edge.to));
    }
    if (!edge.enabled) continue;
    sets.Join(static_cast<std::size_t>(index.at(edge.from)), static_cast<std::size_t>(index.at(edge.to)));
  }
  const int nodes = static_cast<int>(graph.nodes.size());
  std::vector<int> component(nodes), position(nodes);
  std::vector<IndexedGraph> components;
  for (int i = 0; i < nodes; ++i) {
    const int root = static_cast<int>(sets.Find(static_cast<std::size_t>(i)));
    if (root == i) {
      component[i] = static_cast<int>(components.size());
      components.emplace_back();
    }
    component[i] = component[root];
    IndexedGraph& part = components[component[i]];
    position[i] = static_cast<int>(part.poses.size());
    part.sources.push_back(i);
    part.poses.push_back(graph.nodes[i].T_world_node);
    part.held.push_back(false);
  }
  for (const std::int64_t id : fixed) {
    const auto found = index.find(id);
    if (found == index.end()) return InvalidArgument("pose graph: there is no node {} to hold fixed", id);
    components[component[found->second]].held[position[found->second]] = true;
  }
  for (IndexedGraph& part : components) {
    if (std::find(part.held.begin(), part.held.end(), true) == part.held.end()) part.held.front() = true;
  }
  for (const PoseGraphEdge& edge : graph.edges) {
    if (!edge.enabled) continue;
    const int from = index.at(edge.from);
    const int to = index.at(edge.to);
    components[component[from]].edges.push_back(
        {position[from], position[to], edge.robust, EdgeMeasurement(edge.T_from_to), edge.information});
  }
  return components;
}

}  // namespace enfilade::optimize
