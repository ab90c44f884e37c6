// SPDX-License-Identifier: Apache-2.0
#include "server/app/graph/graph_page.h"

#include <gmock/gmock.h>

#include <limits>
#include <string>

#include "fmt/format.h"
#include "tests/support/status_assertions.h"

namespace enfilade::server {
namespace {

using ::testing::IsEmpty;
using ::testing::SizeIs;

// Map "hall" with `doors` doors in a row, each into a room of its own, and a candidate.
SiteGraph MakeHall(int doors) {
  graph::SnapshotChanges changes{.version = 7, .root = MapId("hall")};
  changes.maps.push_back({.id = MapId("hall"), .display_name = "Hall"});
  const auto anchor = [](const std::string& map, double x) {
    return graph::Anchor{MapId(map), {x, 0, 0}, graph::DefaultAnchorCovariance()};
  };
  for (int i = 0; i < doors; ++i) {
    changes.maps.push_back({.id = MapId(fmt::format("room-{}", i)), .display_name = fmt::format("Room {}", i)});
    graph::LinkPoint door;
    door.id = LinkPointId(fmt::format("door-{}", i));
    door.anchors = {anchor("hall", i), anchor(fmt::format("room-{}", i), 0)};
    changes.link_points.push_back(door);
  }
  graph::LinkPoint candidate;
  candidate.id = LinkPointId("candidate");
  candidate.anchors = {anchor("hall", 0.5)};
  changes.link_points.push_back(candidate);
  auto snapshot = Apply(graph::GraphSnapshot(), changes);
  EXPECT_OK(snapshot);
  return SiteGraph(*std::move(snapshot));
}

// The items of all pages, as text.
std::vector<std::string> ListAll(const SiteGraph& graph, std::size_t limit, bool with_edges) {
  std::vector<std::string> items;
  std::optional<GraphPosition> at = GraphPosition();
  while (at) {
    const GraphPage page = ListPage(graph, *at, limit, with_edges);
    EXPECT_LE(page.maps.size() + page.link_points.size() + page.edges.size(), limit);
    for (const auto* map : page.maps) items.push_back(map->id.value());
    for (const auto* point : page.link_points) items.push_back(point->id.value());
    for (const GraphEdge& edge : page.edges) {
      items.push_back(
          fmt::format("{}: {} - {}: {}", edge.map->id.value(), edge.a->id.value(), edge.b->id.value(), edge.length));
    }
    EXPECT_FALSE(page.next && *page.next == *at) << "it goes on";
    if (page.next && *page.next == *at) break;
    at = page.next;
  }
  return items;
}

TEST(GraphPage, PagesOfAnySizeAreTheWholeInOrder) {
  const SiteGraph graph = MakeHall(4);
  const std::vector<std::string> whole = ListAll(graph, 1000, true);
  EXPECT_THAT(whole, ::testing::ElementsAre(
                         "hall", "room-0", "room-1", "room-2", "room-3", "candidate", "door-0", "door-1", "door-2",
                         "door-3", "hall: door-0 - door-1: 1", "hall: door-0 - door-2: 2", "hall: door-0 - door-3: 3",
                         "hall: door-1 - door-2: 1", "hall: door-1 - door-3: 2", "hall: door-2 - door-3: 1"));
  for (std::size_t limit = 1; limit <= whole.size() + 1; ++limit) EXPECT_EQ(ListAll(graph, limit, true), whole);
  EXPECT_EQ(CountEdges(graph.graph()), 6U);
}

TEST(GraphPage, EdgesAreListedIfTheyAreAskedFor) {
  const SiteGraph graph = MakeHall(2000);
  EXPECT_EQ(CountEdges(graph.graph()), 1'999'000U);
  const GraphPage page = ListPage(graph, {}, 10'000, /*with_edges=*/false);
  EXPECT_THAT(page.maps, SizeIs(2001));
  EXPECT_THAT(page.link_points, SizeIs(2001));
  EXPECT_THAT(page.edges, IsEmpty());
  EXPECT_FALSE(page.next.has_value());
  const GraphPage edges = ListPage(graph, {.part = GraphPosition::Part::kEdges}, 1000, /*with_edges=*/true);
  EXPECT_THAT(edges.edges, SizeIs(1000));
  EXPECT_EQ(edges.next, (GraphPosition{.part = GraphPosition::Part::kEdges, .index = 0, .first = 0, .second = 1001}));
}

TEST(GraphPage, AnEmptyGraphHasOneEmptyPage) {
  const GraphPage page = ListPage(SiteGraph(graph::GraphSnapshot()), {}, 10, /*with_edges=*/true);
  EXPECT_THAT(page.maps, IsEmpty());
  EXPECT_FALSE(page.next.has_value());
}

TEST(GraphPage, APositionBehindTheEndIsTheEnd) {
  constexpr std::size_t kMost = std::numeric_limits<std::size_t>::max();
  const SiteGraph graph = MakeHall(3);
  for (const auto part : {GraphPosition::Part::kMaps, GraphPosition::Part::kLinkPoints, GraphPosition::Part::kEdges}) {
    EXPECT_THAT(ListPage(graph, {.part = part, .index = kMost}, 10, false).maps, IsEmpty());
    const GraphPage page =
        ListPage(graph, {.part = part, .index = 0, .first = kMost, .second = kMost}, 1000, /*with_edges=*/true);
    EXPECT_EQ(page.edges.empty(), part == GraphPosition::Part::kEdges);
    EXPECT_FALSE(page.next.has_value());
  }
}

}  // namespace
}  // namespace enfilade::server
