// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/graph/graph_snapshot.h"
#include "server/app/graph/site_graph.h"

namespace enfilade::server {

// A place in the list that a graph is read as: its maps, then its link points, then its edges. Maps and link points are
// in the order of their ids, edges in that of their maps, and within a map of their link points: of each pair once.
struct GraphPosition {
  enum class Part : std::uint8_t { kMaps = 0, kLinkPoints = 1, kEdges = 2 };
  Part part = Part::kMaps;
  std::size_t index = 0;   // of the map or link point; of the map that an edge lies in
  std::size_t first = 0;   // of an edge: its link point among the map's that join maps ...
  std::size_t second = 1;  // ... and the other one, with a greater index

  friend bool operator==(const GraphPosition&, const GraphPosition&) = default;
};

struct GraphEdge {
  const graph::MapInGraph* map = nullptr;
  const graph::LinkPoint* a = nullptr;
  const graph::LinkPoint* b = nullptr;
  double length = 0.0;  // m, straight
};

// Valid as long as the graph.
struct GraphPage {
  std::vector<const graph::MapInGraph*> maps = {};
  std::vector<const graph::LinkPoint*> link_points = {};
  std::vector<GraphEdge> edges = {};
  std::optional<GraphPosition> next = {};  // unset: that was all
};

// At most `limit` items of the list from `begin` on; its edges only `with_edges`. A position behind the end is the end.
GraphPage ListPage(const SiteGraph& graph, GraphPosition begin, std::size_t limit, bool with_edges);

// A map with d link points that join maps has d (d - 1) / 2.
std::size_t CountEdges(const graph::GraphSnapshot& graph);

}  // namespace enfilade::server
