// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "core/optimize/solve_pose_graph.h"
#include "tests/support/manhattan_graph.h"
#include "tests/support/status_assertions.h"

namespace enfilade::optimize {
namespace {

using testing::MakeManhattanGraph;
using testing::ManhattanGraph;
using testing::RootMeanSquareError;

class RobustSolveTest : public ::testing::TestWithParam<RobustKernel::Type> {};

TEST_P(RobustSolveTest, IsHardlyMovedByAWrongLoop) {
  ManhattanGraph world = MakeManhattanGraph({.nodes = 200, .loops_per_node = 0.5});
  PoseGraph clean = world.graph;
  ASSERT_OK(SolvePoseGraph({}, clean));
  world.graph.edges.push_back({20, 150, {0.3, -0.2, 1.0}, world.graph.edges.front().information});
  PoseGraph misled = world.graph;
  ASSERT_OK(SolvePoseGraph({}, misled));
  ASSERT_OK_AND_ASSIGN(const SolveReport report, SolvePoseGraph({.kernel = {GetParam(), 2.0}}, world.graph));
  EXPECT_TRUE(report.converged);
  EXPECT_LT(report.edge_weight.back(), 0.05);
  EXPECT_GT(report.edge_chi2.back(), 100.0);
  const double clean_error = RootMeanSquareError(clean, world.truth);
  EXPECT_GT(RootMeanSquareError(misled, world.truth), clean_error + 0.3);
  EXPECT_LT(RootMeanSquareError(world.graph, world.truth), clean_error + 0.1);
}

INSTANTIATE_TEST_SUITE_P(Kernels, RobustSolveTest,
                         ::testing::Values(RobustKernel::Type::kHuber, RobustKernel::Type::kCauchy,
                                           RobustKernel::Type::kDcs));

TEST(RobustSolve, RejectsManyWrongLoops) {
  const ManhattanGraph world = MakeManhattanGraph({.nodes = 400, .outlier_share = 0.2});
  for (const auto type : {RobustKernel::Type::kCauchy, RobustKernel::Type::kDcs}) {
    PoseGraph graph = world.graph;
    ASSERT_OK_AND_ASSIGN(const SolveReport report, SolvePoseGraph({.kernel = {type, 2.0}}, graph));
    EXPECT_LT(RootMeanSquareError(graph, world.truth), 0.15);
    for (std::size_t k = 0; k < graph.edges.size(); ++k) {
      if (world.is_outlier[k]) {
        EXPECT_LT(report.edge_weight[k], 0.1) << "edge " << k;
      } else {
        EXPECT_GT(report.edge_weight[k], 0.02) << "edge " << k << " with chi2 " << report.edge_chi2[k];
      }
    }
  }
}

// A kernel narrower than the noise takes right edges for wrong wherever it can.
TEST(RobustSolve, FindsTheMinimumNearTheTruthWithANarrowKernel) {
  const ManhattanGraph world = MakeManhattanGraph({.nodes = 400, .outlier_share = 0.3, .seed = 2});
  for (const auto type : {RobustKernel::Type::kCauchy, RobustKernel::Type::kDcs}) {
    PoseGraph from_odometry = world.graph;
    PoseGraph from_truth = world.graph;
    for (std::size_t i = 0; i < world.truth.size(); ++i) from_truth.nodes[i].T_world_node = world.truth[i];
    ASSERT_OK_AND_ASSIGN(const SolveReport found, SolvePoseGraph({.kernel = {type, 1.0}}, from_odometry));
    ASSERT_OK_AND_ASSIGN(const SolveReport expected,
                         SolvePoseGraph({.initialisation = Initialisation::kNone, .kernel = {type, 1.0}}, from_truth));
    EXPECT_LT(found.final_cost, 1.05 * expected.final_cost) << "as deep, if not the same, of many minima";
    EXPECT_LT(RootMeanSquareError(from_odometry, world.truth), 0.2);
  }
}

TEST(RobustSolve, AppliesToRobustEdgesOnly) {
  PoseGraph graph = MakeManhattanGraph({.nodes = 60}).graph;
  graph.edges.push_back({5, 50, {9.0, 9.0, 0.0}, graph.edges.front().information, false});
  ASSERT_OK_AND_ASSIGN(const SolveReport report, SolvePoseGraph({.kernel = {RobustKernel::Type::kDcs, 1.0}}, graph));
  EXPECT_EQ(report.edge_weight.back(), 1.0);
  EXPECT_LT(report.final_cost, report.final_chi2);
}

}  // namespace
}  // namespace enfilade::optimize
