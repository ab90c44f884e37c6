// SPDX-License-Identifier: Apache-2.0
#include "core/optimize/initialization/spanning_tree.h"

#include <gtest/gtest.h>

#include <set>

#include "tests/support/manhattan_graph.h"
#include "tests/support/pose_matchers.h"
#include "tests/support/status_assertions.h"

namespace enfilade::optimize {
namespace {

using testing::PoseNear;

IndexedGraph FirstComponent(const PoseGraph& graph, const std::vector<std::int64_t>& fixed) {
  const auto components = IndexComponents(graph, fixed);
  EXPECT_OK(components);
  return components->front();
}

// In edges, from the nearest held node.
std::vector<int> Depths(const IndexedGraph& graph) {
  std::vector<int> depth(graph.poses.size(), 1'000'000);
  for (std::size_t i = 0; i < depth.size(); ++i) {
    if (graph.held[i]) depth[i] = 0;
  }
  for (bool changed = true; changed;) {
    changed = false;
    for (const IndexedEdge& edge : graph.edges) {
      for (const auto& [a, b] : {std::pair{edge.from, edge.to}, std::pair{edge.to, edge.from}}) {
        if (depth[a] + 1 >= depth[b]) continue;
        depth[b] = depth[a] + 1;
        changed = true;
      }
    }
  }
  return depth;
}

TEST(SpanningTreePoses, AreExactWithoutNoise) {
  testing::ManhattanGraph world = testing::MakeManhattanGraph({.nodes = 80, .sigma_xy = 1e-12, .sigma_yaw = 1e-12});
  for (PoseGraphNode& node : world.graph.nodes) node.T_world_node = {-9.0, 9.0, 3.0};
  for (const std::vector<std::int64_t>& held : {std::vector<std::int64_t>{0}, {79}, {5, 40, 41}}) {
    for (const std::int64_t id : held) world.graph.nodes[id].T_world_node = world.truth[id];
    const std::vector<Pose2> poses = SpanningTreePoses(FirstComponent(world.graph, held));
    for (std::size_t i = 0; i < poses.size(); ++i) EXPECT_THAT(poses[i], PoseNear(world.truth[i], 1e-8, 1e-8)) << i;
  }
}

TEST(SpanningTreePoses, KeepTheHeldNodes) {
  const PoseGraph graph = testing::MakeManhattanGraph({.nodes = 40}).graph;
  const std::vector<Pose2> poses = SpanningTreePoses(FirstComponent(graph, {3, 17}));
  EXPECT_EQ(poses[3], graph.nodes[3].T_world_node);
  EXPECT_EQ(poses[17], graph.nodes[17].T_world_node);
}

// Every free node satisfies exactly one edge to a node that is nearer to a held one: errors add up over as few edges as
// there can be.
TEST(SpanningTreePoses, FollowShortestPathsFromHeldNodes) {
  for (std::uint32_t seed = 1; seed <= 8; ++seed) {
    const IndexedGraph graph =
        FirstComponent(testing::MakeManhattanGraph({.nodes = 60, .sigma_xy = 0.1, .seed = seed}).graph, {0, 30});
    const std::vector<Pose2> poses = SpanningTreePoses(graph);
    const std::vector<int> depth = Depths(graph);
    std::set<int> placed;
    for (const IndexedEdge& edge : graph.edges) {
      if (EdgeError(poses[edge.from], poses[edge.to], edge.measurement).norm() > 1e-9) continue;
      if (depth[edge.from] + 1 == depth[edge.to]) placed.insert(edge.to);
      if (depth[edge.to] + 1 == depth[edge.from]) placed.insert(edge.from);
    }
    for (std::size_t i = 0; i < poses.size(); ++i) {
      EXPECT_EQ(placed.contains(static_cast<int>(i)), depth[i] > 0) << "seed " << seed << ", node " << i;
    }
  }
}

TEST(SpanningTreePoses, FollowEdgesAgainstTheirDirection) {
  PoseGraph graph;
  graph.nodes = {{0, {1.0, 2.0, 0.5}}, {1, {}}};
  graph.edges.push_back({1, 0, {0.3, -0.4, 1.2}});
  const std::vector<Pose2> poses = SpanningTreePoses(FirstComponent(graph, {0}));
  EXPECT_THAT(poses[1] * Pose2(0.3, -0.4, 1.2), PoseNear(graph.nodes[0].T_world_node, 1e-12, 1e-12));
}

}  // namespace
}  // namespace enfilade::optimize
