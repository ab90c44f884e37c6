// SPDX-License-Identifier: Apache-2.0
#include "core/optimize/initialization/spanning_tree.h"

namespace enfilade::optimize {
namespace {

std::vector<std::vector<int>> IncidentEdges(const IndexedGraph& graph) {
  std::vector<std::vector<int>> incident(graph.poses.size());
  for (std::size_t k = 0; k < graph.edges.size(); ++k) {
    incident[graph.edges[k].from].push_back(static_cast<int>(k));
    incident[graph.edges[k].to].push_back(static_cast<int>(k));
  }
  return incident;
}

}  // namespace

std::vector<Pose2> SpanningTreePoses(const IndexedGraph& graph) {
  const std::vector<std::vector<int>> incident = IncidentEdges(graph);
  std::vector<Pose2> poses = graph.poses;
  std::vector<char> reached = graph.held;
  std::vector<int> queue;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (graph.held[i]) queue.push_back(static_cast<int>(i));
  }
  for (std::size_t head = 0; head < queue.size(); ++head) {
    const int i = queue[head];
    for (const int k : incident[i]) {
      const IndexedEdge& edge = graph.edges[k];
      const int j = edge.from == i ? edge.to : edge.from;
      if (reached[j]) continue;
      reached[j] = true;
      const Pose2& T_from_to = edge.measurement.T_from_to;
      poses[j] = poses[i] * (edge.from == i ? T_from_to : Inverse(T_from_to));
      queue.push_back(j);
    }
  }
  return poses;
}

}  // namespace enfilade::optimize
