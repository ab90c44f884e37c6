// SPDX-License-Identifier: Apache-2.0
#include "server/app/graph/graph_page.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace enfilade::server {
namespace {

using Part = GraphPosition::Part;

// Behind every end, and far from an overflow.
constexpr std::size_t kFar = std::numeric_limits<std::size_t>::max() / 2;

std::size_t SizeOf(const GraphPage& page) { return page.maps.size() + page.link_points.size() + page.edges.size(); }

// Appends items of `all` from position.index on, until the page is full or the next part begins.
template <typename Item>
void TakeItems(const std::vector<const Item*>& all, std::size_t limit, GraphPosition& position, GraphPage& page,
               std::vector<const Item*>& out) {
  while (position.index < all.size() && SizeOf(page) < limit) out.push_back(all[position.index++]);
  if (position.index < all.size()) return;
  position = {.part = position.part == Part::kMaps ? Part::kLinkPoints : Part::kEdges};
}

// The same for edges. True at their end.
bool TakeEdges(const SiteGraph& graph, std::size_t limit, GraphPosition& position, GraphPage& page) {
  const std::vector<const graph::MapInGraph*>& maps = graph.lists().maps;
  for (; position.index < maps.size(); position = {.part = Part::kEdges, .index = position.index + 1}) {
    const graph::MapInGraph& map = *maps[position.index];
    const auto& doorways = graph.graph().map_node(graph.graph().MapSlot(map.id)).doorways;
    const auto at = [&](std::size_t i) {
      return graph.graph().link_point_node(doorways[i].link_point).link_point.get();
    };
    for (; position.first + 1 < doorways.size(); position.second = ++position.first + 1) {
      for (; position.second < doorways.size(); ++position.second) {
        if (SizeOf(page) == limit) return false;
        const auto& a = doorways[position.first];
        const auto& b = doorways[position.second];
        page.edges.push_back({&map, at(position.first), at(position.second), std::hypot(b.x - a.x, b.y - a.y)});
      }
    }
  }
  return true;
}

}  // namespace

GraphPage ListPage(const SiteGraph& graph, GraphPosition begin, std::size_t limit, bool with_edges) {
  GraphPage page;
  GraphPosition position = begin;
  position.first = std::min(position.first, kFar);
  position.second = std::max(position.second, position.first + 1);
  if (position.part == Part::kMaps) TakeItems(graph.lists().maps, limit, position, page, page.maps);
  if (position.part == Part::kLinkPoints) {
    TakeItems(graph.lists().link_points, limit, position, page, page.link_points);
  }
  const bool at_edges = position.part == Part::kEdges;
  const bool at_end = at_edges && (!with_edges || TakeEdges(graph, limit, position, page));
  if (!at_end) page.next = position;
  return page;
}

std::size_t CountEdges(const graph::GraphSnapshot& graph) {
  std::size_t edges = 0;
  for (std::size_t i = 0; i < graph.map_slots(); ++i) {
    const std::size_t doorways = graph.map_node(static_cast<int>(i)).doorways.size();
    if (doorways > 1) edges += doorways * (doorways - 1) / 2;
  }
  return edges;
}

}  // namespace enfilade::server
