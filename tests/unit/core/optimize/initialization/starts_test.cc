// SPDX-License-Identifier: Apache-2.0
#include "core/optimize/initialization/starts.h"

#include <gtest/gtest.h>

#include "core/optimize/graph_layout.h"
#include "core/optimize/indexed_graph.h"
#include "core/optimize/linear/normal_equations.h"
#include "tests/support/manhattan_graph.h"
#include "tests/support/status_assertions.h"

namespace enfilade::optimize {
namespace {

// A circle whose measurements turn once around; given poses that turn twice are a minimum of their own.
PoseGraph Circle(int turns_of_guess) {
  PoseGraph graph;
  Pose2 pose;
  const int n = 20;
  for (int i = 0; i < n; ++i) {
    graph.nodes.push_back({i, pose});
    graph.edges.push_back({i, (i + 1) % n, {1.0, 0.0, 2.0 * M_PI / n}});
    pose = pose * Pose2{1.0, 0.0, turns_of_guess * 2.0 * M_PI / n};
  }
  return graph;
}

class StartsTest : public ::testing::Test {
 protected:
  Minimum FromGivenPoses(const PoseGraph& graph) { return Run(graph, false); }
  Minimum FromSeveralStarts(const PoseGraph& graph) { return Run(graph, true); }

  std::vector<Pose2> solution_;

 private:
  Minimum Run(const PoseGraph& graph, bool several) {
    const auto components = IndexComponents(graph, {});
    EXPECT_OK(components);
    IndexedGraph indexed = components->front();
    const GraphLayout layout = LayOut(indexed);
    const Minimum minimum = several ? MinimizeFromSeveralStarts({}, layout, indexed) : Minimize({}, layout, indexed);
    solution_ = indexed.poses;
    EXPECT_NEAR(minimum.cost, GraphCost(indexed, indexed.poses, {}), 1e-9);
    return minimum;
  }
};

TEST_F(StartsTest, LeavesAMinimumThatTurnsTooOften) {
  EXPECT_GT(FromGivenPoses(Circle(2)).cost, 1.0);
  EXPECT_LT(FromSeveralStarts(Circle(2)).cost, 1e-9);
}

TEST_F(StartsTest, TakesTheGivenPosesWhenTheyAreRight) {
  const Minimum minimum = FromSeveralStarts(Circle(1));
  EXPECT_LT(minimum.cost, 1e-9);
  EXPECT_EQ(minimum.iterations, 1);
}

TEST_F(StartsTest, FindsTheTruthFromOdometryThatTurnedAway) {
  testing::ManhattanGraph world = testing::MakeManhattanGraph({.nodes = 500});
  for (int i = 0; i < 500; ++i) {  // a gyro drift of 3 degrees a step in the given poses only
    world.graph.nodes[i].T_world_node.yaw = WrapAngle(world.graph.nodes[i].T_world_node.yaw + 0.05 * i);
  }
  const double from_truth = [&] {
    PoseGraph graph = world.graph;
    for (int i = 0; i < 500; ++i) graph.nodes[i].T_world_node = world.truth[i];
    return FromGivenPoses(graph).cost;
  }();
  EXPECT_NEAR(FromSeveralStarts(world.graph).cost, from_truth, 1e-6 * from_truth);
}

}  // namespace
}  // namespace enfilade::optimize
