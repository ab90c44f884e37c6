// SPDX-License-Identifier: Apache-2.0
#include "core/optimize/graph_layout.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/manhattan_graph.h"
#include "tests/support/status_assertions.h"

namespace enfilade::optimize {
namespace {

class GraphLayoutTest : public ::testing::TestWithParam<std::vector<std::int64_t>> {
 protected:
  void SetUp() override {
    ASSERT_OK_AND_ASSIGN(std::vector<IndexedGraph> components,
                         IndexComponents(testing::MakeManhattanGraph({.nodes = 60, .seed = 3}).graph, GetParam()));
    graph_ = std::move(components.front());
    layout_ = LayOut(graph_);
  }

  IndexedGraph graph_;
  GraphLayout layout_;
};

TEST_P(GraphLayoutTest, GivesEveryFreeNodeARowOfItsOwn) {
  std::vector<int> rows;
  for (std::size_t i = 0; i < graph_.poses.size(); ++i) {
    EXPECT_EQ(layout_.position[i] < 0, static_cast<bool>(graph_.held[i])) << "node " << i;
    if (layout_.position[i] >= 0) rows.push_back(layout_.position[i]);
  }
  std::sort(rows.begin(), rows.end());
  ASSERT_EQ(static_cast<int>(rows.size()), layout_.structure.size);
  for (int k = 0; k < layout_.structure.size; ++k) EXPECT_EQ(rows[k], k);
}

TEST_P(GraphLayoutTest, PutsEachEdgeIntoTheBlockOfItsNodes) {
  ASSERT_EQ(layout_.block.size(), graph_.edges.size());
  for (std::size_t k = 0; k < graph_.edges.size(); ++k) {
    const IndexedEdge& edge = graph_.edges[k];
    const auto [low, high] = std::minmax(layout_.position[edge.from], layout_.position[edge.to]);
    if (low < 0) {
      EXPECT_EQ(layout_.block[k], -1) << "edge " << k << " has a held end";
      continue;
    }
    ASSERT_GE(layout_.block[k], 0);
    EXPECT_EQ(layout_.structure.row[layout_.block[k]], high);
    EXPECT_EQ(layout_.structure.column[layout_.block[k]], low);
  }
}

TEST_P(GraphLayoutTest, DependsOnTopologyAndHeldNodesOnly) {
  IndexedGraph other = graph_;
  for (Pose2& pose : other.poses) pose = {1.0, 2.0, 3.0};
  for (IndexedEdge& edge : other.edges) {
    edge.information *= 7.0;
    edge.measurement = EdgeMeasurement({0.5, 0.5, 0.5});
    edge.robust = !edge.robust;
  }
  const GraphLayout again = LayOut(other);
  EXPECT_EQ(again.position, layout_.position);
  EXPECT_EQ(again.block, layout_.block);
  EXPECT_EQ(again.structure.row, layout_.structure.row);
}

INSTANTIATE_TEST_SUITE_P(Held, GraphLayoutTest,
                         ::testing::Values(std::vector<std::int64_t>{}, std::vector<std::int64_t>{30},
                                           std::vector<std::int64_t>{0, 1, 2, 3, 59}));

TEST(GraphLayout, HasNoRowsIfAllNodesAreHeld) {
  ASSERT_OK_AND_ASSIGN(const std::vector<IndexedGraph> components,
                       IndexComponents({{{1, {}}, {2, {1.0, 0.0, 0.0}}}, {{1, 2, {1.0, 0.0, 0.0}}}}, {1, 2}));
  const GraphLayout layout = LayOut(components.front());
  EXPECT_EQ(layout.structure.size, 0);
  EXPECT_EQ(layout.block, std::vector<int>{-1});
}

}  // namespace
}  // namespace enfilade::optimize
