// SPDX-License-Identifier: Apache-2.0
#include "core/optimize/ceres/ceres_minimize.h"

#include <gtest/gtest.h>

#include "core/optimize/graph_layout.h"
#include "core/optimize/linear/normal_equations.h"
#include "core/optimize/solve_pose_graph.h"
#include "tests/support/manhattan_graph.h"
#include "tests/support/pose_matchers.h"
#include "tests/support/status_assertions.h"

namespace enfilade::optimize {
namespace {

using testing::PoseNear;

TEST(MinimizeWithCeres, SolvesWhatTheDefaultMinimizerSolves) {
  const PoseGraph given = testing::MakeManhattanGraph({.nodes = 120, .seed = 2}).graph;
  PoseGraph blocks = given;
  PoseGraph ceres = given;
  ASSERT_OK_AND_ASSIGN(const SolveReport ours, SolvePoseGraph({}, blocks));
  ASSERT_OK_AND_ASSIGN(const SolveReport theirs, SolvePoseGraph({.minimizer = &MinimizeWithCeres}, ceres));
  EXPECT_TRUE(theirs.converged);
  EXPECT_NEAR(theirs.final_chi2, ours.final_chi2, 1e-6 * ours.final_chi2);
  for (std::size_t i = 0; i < given.nodes.size(); ++i) {
    EXPECT_THAT(ceres.nodes[i].T_world_node, PoseNear(blocks.nodes[i].T_world_node, 1e-4, 1e-4));
  }
}

TEST(MinimizeWithCeres, KeepsHeldNodesAndReportsTheCostOfItsResult) {
  ASSERT_OK_AND_ASSIGN(std::vector<IndexedGraph> components,
                       IndexComponents(testing::MakeManhattanGraph({.nodes = 60}).graph, {0, 25, 59}));
  IndexedGraph& graph = components.front();
  const std::vector<Pose2> before = graph.poses;
  const RobustKernel kernel{RobustKernel::Type::kHuber, 1.5};
  const Minimum minimum = MinimizeWithCeres({.kernel = kernel}, LayOut(graph), graph);
  for (const int i : {0, 25, 59}) EXPECT_EQ(graph.poses[i], before[i]);
  EXPECT_NE(graph.poses[30].x, before[30].x);
  EXPECT_DOUBLE_EQ(minimum.cost, GraphCost(graph, graph.poses, kernel));
  EXPECT_LT(minimum.cost, GraphCost(graph, before, kernel));
}

TEST(MinimizeWithCeres, StopsAtTheIterationsAllowed) {
  ASSERT_OK_AND_ASSIGN(std::vector<IndexedGraph> components,
                       IndexComponents(testing::MakeManhattanGraph({.nodes = 200}).graph, {}));
  const Minimum minimum = MinimizeWithCeres({.max_iterations = 1}, LayOut(components[0]), components[0]);
  EXPECT_LE(minimum.iterations, 1);
  EXPECT_FALSE(minimum.converged);
}

// The kernel leaves edges alone that are not robust: with all edges so, the kernel changes nothing.
TEST(MinimizeWithCeres, AppliesTheKernelToRobustEdgesOnly) {
  PoseGraph graph = testing::MakeManhattanGraph({.nodes = 80}).graph;
  for (PoseGraphEdge& edge : graph.edges) edge.robust = false;
  PoseGraph plain = graph;
  const RobustKernel cauchy{RobustKernel::Type::kCauchy, 0.5};
  ASSERT_OK(SolvePoseGraph({.initialisation = Initialisation::kNone, .kernel = cauchy, .minimizer = &MinimizeWithCeres},
                           graph));
  ASSERT_OK(SolvePoseGraph({.initialisation = Initialisation::kNone, .minimizer = &MinimizeWithCeres}, plain));
  for (std::size_t i = 0; i < graph.nodes.size(); ++i) {
    EXPECT_EQ(graph.nodes[i].T_world_node, plain.nodes[i].T_world_node);
  }
}

}  // namespace
}  // namespace enfilade::optimize
