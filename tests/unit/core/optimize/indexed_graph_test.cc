// SPDX-License-Identifier: Apache-2.0
#include "core/optimize/indexed_graph.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <set>

#include "tests/support/status_assertions.h"

namespace enfilade::optimize {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

PoseGraph GraphOf(const std::vector<std::int64_t>& ids,
                  const std::vector<std::pair<std::int64_t, std::int64_t>>& pairs) {
  PoseGraph graph;
  for (const std::int64_t id : ids) graph.nodes.push_back({id, {static_cast<double>(id), 0.5, 0.1}});
  for (const auto& [from, to] : pairs) graph.edges.push_back({from, to, {1.0, 0.0, 0.0}});
  return graph;
}

TEST(IndexComponents, OrdersComponentsByTheirFirstNodes) {
  const PoseGraph graph = GraphOf({7, -3, 900, 4, 5}, {{4, 7}, {900, -3}});
  ASSERT_OK_AND_ASSIGN(const std::vector<IndexedGraph> components, IndexComponents(graph, {}));
  ASSERT_THAT(components, SizeIs(3));
  EXPECT_THAT(components[0].sources, ElementsAre(0, 3));
  EXPECT_THAT(components[1].sources, ElementsAre(1, 2));
  EXPECT_THAT(components[2].sources, ElementsAre(4));
  ASSERT_THAT(components[0].edges, SizeIs(1));
  EXPECT_EQ(components[0].edges[0].from, 1) << "node 4";
  EXPECT_EQ(components[0].edges[0].to, 0) << "node 7";
  EXPECT_EQ(components[1].edges[0].from, 1) << "node 900";
  EXPECT_TRUE(components[2].edges.empty());
}

TEST(IndexComponents, CopiesWhatEdgesAndNodesHold) {
  PoseGraph graph = GraphOf({1, 2}, {{2, 1}});
  graph.edges[0].T_from_to = {0.3, -0.2, 0.7};
  graph.edges[0].information = Eigen::Vector3d(1.0, 2.0, 3.0).asDiagonal();
  graph.edges[0].robust = false;
  ASSERT_OK_AND_ASSIGN(const std::vector<IndexedGraph> components, IndexComponents(graph, {}));
  const IndexedGraph& only = components.at(0);
  EXPECT_EQ(only.poses[0], graph.nodes[0].T_world_node);
  EXPECT_EQ(only.poses[1], graph.nodes[1].T_world_node);
  const IndexedEdge& edge = only.edges.at(0);
  EXPECT_EQ(edge.measurement.T_from_to, graph.edges[0].T_from_to);
  EXPECT_EQ(edge.information, graph.edges[0].information);
  EXPECT_FALSE(edge.robust);
}

TEST(IndexComponents, LeavesDisabledEdgesOutAndLetsThemJoinNothing) {
  PoseGraph graph = GraphOf({0, 1, 2}, {{0, 1}, {1, 2}});
  graph.edges[1].enabled = false;
  ASSERT_OK_AND_ASSIGN(const std::vector<IndexedGraph> components, IndexComponents(graph, {}));
  ASSERT_THAT(components, SizeIs(2));
  EXPECT_THAT(components[0].edges, SizeIs(1));
  EXPECT_THAT(components[1].edges, SizeIs(0));
}

TEST(IndexComponents, HoldsTheFixedNodesOrElseTheFirst) {
  const PoseGraph graph = GraphOf({10, 11, 12, 20, 21}, {{10, 11}, {11, 12}, {20, 21}});
  ASSERT_OK_AND_ASSIGN(const std::vector<IndexedGraph> components, IndexComponents(graph, {12, 11, 11}));
  ASSERT_THAT(components, SizeIs(2));
  EXPECT_THAT(components[0].held, ElementsAre(false, true, true));
  EXPECT_THAT(components[1].held, ElementsAre(true, false));
}

TEST(IndexComponents, OfAnEmptyGraphAreNone) {
  ASSERT_OK_AND_ASSIGN(const std::vector<IndexedGraph> components, IndexComponents({}, {}));
  EXPECT_TRUE(components.empty());
}

// Reachability by walking the edges, over random graphs.
TEST(IndexComponents, AreWhatEdgesConnect) {
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    std::mt19937 random(seed);
    constexpr int kNodes = 30;
    std::uniform_int_distribution<int> any(0, kNodes - 1);
    std::vector<std::int64_t> ids;
    for (int i = 0; i < kNodes; ++i) ids.push_back(100 - 3 * i);
    std::vector<std::pair<std::int64_t, std::int64_t>> pairs;
    for (int k = 0; k < 20; ++k) {
      const int a = any(random);
      const int b = any(random);
      if (a != b) pairs.emplace_back(ids[a], ids[b]);
    }
    ASSERT_OK_AND_ASSIGN(const std::vector<IndexedGraph> components, IndexComponents(GraphOf(ids, pairs), {}));
    std::set<int> seen;
    for (const IndexedGraph& part : components) {
      std::set<std::int64_t> reached{ids[part.sources.front()]};
      for (bool grown = true; grown;) {
        grown = false;
        for (const auto& [a, b] : pairs) {
          if (reached.contains(a) != reached.contains(b)) grown = reached.insert(reached.contains(a) ? b : a).second;
          if (grown) break;
        }
      }
      std::set<std::int64_t> members;
      for (const int source : part.sources) {
        members.insert(ids[source]);
        EXPECT_TRUE(seen.insert(source).second) << "a node is in one component only";
      }
      EXPECT_EQ(members, reached) << "seed " << seed;
    }
    EXPECT_EQ(seen.size(), ids.size());
  }
}

// What else it rejects: SolvePoseGraphRejects.
TEST(IndexComponents, ChecksDisabledEdgesToo) {
  PoseGraph graph = GraphOf({3, 8}, {{3, 8}, {8, 3}});
  graph.edges[1].enabled = false;
  ASSERT_OK(IndexComponents(graph, {}));
  graph.edges[1].to = 99;
  EXPECT_STATUS(IndexComponents(graph, {}), absl::StatusCode::kInvalidArgument,
                AllOf(HasSubstr("edge 8 -> 99"), HasSubstr("no node 99")));
}

}  // namespace
}  // namespace enfilade::optimize
