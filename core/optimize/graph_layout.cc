// SPDX-License-Identifier: Apache-2.0
#include "core/optimize/graph_layout.h"

#include <algorithm>
#include <utility>

namespace enfilade::optimize {

GraphLayout LayOut(const IndexedGraph& graph) {
  GraphLayout layout;
  layout.position.assign(graph.poses.size(), -1);
  int unknowns = 0;
  for (std::size_t i = 0; i < graph.poses.size(); ++i) {
    if (!graph.held[i]) layout.position[i] = unknowns++;
  }
  std::vector<std::pair<int, int>> pairs;
  pairs.reserve(graph.edges.size());
  for (const IndexedEdge& edge : graph.edges) {
    if (graph.held[edge.from] || graph.held[edge.to]) continue;
    pairs.emplace_back(layout.position[edge.from], layout.position[edge.to]);
  }
  layout.structure = AnalyzeBlocks(unknowns, pairs);
  for (int& position : layout.position) {
    if (position >= 0) position = layout.structure.position[position];
  }
  layout.block.reserve(graph.edges.size());
  for (const IndexedEdge& edge : graph.edges) {
    const auto [low, high] = std::minmax(layout.position[edge.from], layout.position[edge.to]);
    layout.block.push_back(low < 0 ? -1 : layout.structure.Block(high, low));
  }
  return layout;
}

}  // namespace enfilade::optimize
