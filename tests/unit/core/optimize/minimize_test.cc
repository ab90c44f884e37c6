// SPDX-License-Identifier: Apache-2.0
#include "core/optimize/minimize.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "core/optimize/ceres/ceres_minimize.h"
#include "core/optimize/graph_layout.h"
#include "core/optimize/indexed_graph.h"
#include "core/optimize/linear/normal_equations.h"
#include "core/optimize/solve_pose_graph.h"
#include "tests/support/manhattan_graph.h"
#include "tests/support/status_assertions.h"

namespace enfilade::optimize {
namespace {

IndexedGraph Indexed(const PoseGraph& graph) {
  const auto components = IndexComponents(graph, {});
  EXPECT_OK(components);
  return components->front();
}

TEST(Minimize, EndsWhereTheGradientVanishes) {
  IndexedGraph graph = Indexed(testing::MakeManhattanGraph({.nodes = 300}).graph);
  const GraphLayout layout = LayOut(graph);
  NormalEquations equations;
  Linearize(graph, layout, {}, equations);
  const double before = equations.b.norm();
  const Minimum minimum = Minimize({}, layout, graph);
  EXPECT_TRUE(minimum.converged);
  EXPECT_LT(minimum.iterations, 15);
  EXPECT_DOUBLE_EQ(minimum.cost, GraphCost(graph, graph.poses, {}));
  Linearize(graph, layout, {}, equations);
  EXPECT_LT(equations.b.norm(), 1e-6 * before);
}

TEST(Minimize, NeedsOneStepInASolvedGraph) {
  IndexedGraph graph = Indexed(testing::MakeManhattanGraph({.nodes = 300}).graph);
  const GraphLayout layout = LayOut(graph);
  const double cost = Minimize({}, layout, graph).cost;
  const Minimum again = Minimize({}, layout, graph);
  EXPECT_TRUE(again.converged);
  EXPECT_EQ(again.iterations, 1);
  EXPECT_NEAR(again.cost, cost, 1e-9 * cost);
}

TEST(Minimize, StopsAtTheIterationsAllowed) {
  IndexedGraph graph = Indexed(testing::MakeManhattanGraph({.nodes = 300}).graph);
  const Minimum minimum = Minimize({.max_iterations = 1}, LayOut(graph), graph);
  EXPECT_EQ(minimum.iterations, 1);
  EXPECT_FALSE(minimum.converged);
}

// Steps of 1 m known to 0.1 mm, turns hardly known, and a loop that does not close: straight steps in the translations
// are too long as soon as the yaws turn.
TEST(Minimize, GoesAlongANarrowBentValley) {
  PoseGraph graph;
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  Pose2 pose;
  const int n = 60;
  for (int i = 0; i < n; ++i) {
    graph.nodes.push_back({i, pose});
    PoseGraphEdge edge{i, (i + 1) % n, {1.0, 0.0, 2.0 * M_PI / n + 0.15 * normal(random)}};
    edge.information.diagonal() << 1e8, 1e8, 1e2;
    graph.edges.push_back(edge);
    pose = pose * edge.T_from_to;
  }
  IndexedGraph indexed = Indexed(graph);
  const GraphLayout layout = LayOut(indexed);
  IndexedGraph with_ceres = indexed;
  const Minimum ours = Minimize({}, layout, indexed);
  const Minimum reference = MinimizeWithCeres({.max_iterations = 5000}, layout, with_ceres);
  EXPECT_TRUE(ours.converged);
  EXPECT_LT(ours.iterations, 30);
  EXPECT_LE(ours.cost, reference.cost * (1.0 + 1e-6));
}

class MinimizeWithKernel : public ::testing::TestWithParam<RobustKernel::Type> {};

TEST_P(MinimizeWithKernel, AgreesWithCeres) {
  const MinimizeOptions options{.kernel = {GetParam(), 2.0}, .max_iterations = 500, .relative_tolerance = 1e-12};
  PoseGraph world = testing::MakeManhattanGraph({.nodes = 250}).graph;
  // From the odometry a kernel that is not convex has several minima; which one is found is not the question here.
  ASSERT_OK(SolvePoseGraph({}, world));
  IndexedGraph ours = Indexed(world);
  const GraphLayout layout = LayOut(ours);
  IndexedGraph theirs = ours;
  const double our_cost = Minimize(options, layout, ours).cost;
  const double their_cost = MinimizeWithCeres(options, layout, theirs).cost;
  EXPECT_NEAR(our_cost, their_cost, 1e-6 * their_cost);
  double farthest = 0.0;
  for (std::size_t i = 0; i < ours.poses.size(); ++i) {
    farthest = std::max(farthest, Between(ours.poses[i], theirs.poses[i]).translation().norm());
  }
  EXPECT_LT(farthest, 1e-4);
}

INSTANTIATE_TEST_SUITE_P(Kernels, MinimizeWithKernel,
                         ::testing::Values(RobustKernel::Type::kNone, RobustKernel::Type::kHuber,
                                           RobustKernel::Type::kCauchy, RobustKernel::Type::kDcs));

}  // namespace
}  // namespace enfilade::optimize
