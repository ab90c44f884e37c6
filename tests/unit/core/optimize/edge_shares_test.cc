// SPDX-License-Identifier: Apache-2.0
#include "core/optimize/edge_shares.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "core/optimize/solve_pose_graph.h"
#include "tests/support/manhattan_graph.h"
#include "tests/support/status_assertions.h"

namespace enfilade::optimize {
namespace {

TEST(EdgeShares, AddUpToTheMarginalCovariance) {
  PoseGraph graph = testing::MakeManhattanGraph({.nodes = 80}).graph;
  for (std::size_t i = 0; i < graph.edges.size(); i += 3) graph.edges[i].information *= 1.0 + static_cast<double>(i);
  SolveOptions options;
  options.covariance_of = {79, 40};
  ASSERT_OK_AND_ASSIGN(const SolveReport report, SolvePoseGraph(options, graph));
  for (const NodeCovariance& node : report.covariances) {
    ASSERT_OK_AND_ASSIGN(const auto shares, EdgeShares(graph, {}, node.id));
    ASSERT_EQ(shares.size(), graph.edges.size());
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    for (const Eigen::Matrix3d& share : shares) {
      sum += share;
      EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(share).eigenvalues()(0), -1e-9 * node.covariance.norm());
    }
    EXPECT_LT((sum - node.covariance).norm(), 1e-8 * node.covariance.norm()) << "node " << node.id;
  }
}

PoseGraph Chain() {
  PoseGraph graph;
  for (int i = 0; i < 4; ++i) graph.nodes.push_back({.id = 10 + i, .T_world_node = {1.0 * i, 0.0, 0.0}});
  for (int i = 0; i < 3; ++i) {
    graph.edges.push_back({.from = 10 + i, .to = 11 + i, .T_from_to = {1.0, 0.0, 0.0}});
    graph.edges.back().information = Eigen::Vector3d(100.0, 25.0, 1e6).asDiagonal();
  }
  return graph;
}

TEST(EdgeShares, OfAChainAreItsSteps) {
  ASSERT_OK_AND_ASSIGN(const auto shares, EdgeShares(Chain(), {10}, 12));
  for (const std::size_t step : {0, 1}) {
    EXPECT_NEAR(shares[step](0, 0), 0.01, 1e-9);
    EXPECT_NEAR(shares[step](2, 2), 1e-6, 1e-12);
  }
  // The first step's yaw moves the node sideways, over the step that follows.
  EXPECT_NEAR(shares[0](1, 1), 0.04 + 1e-6, 1e-9);
  EXPECT_NEAR(shares[1](1, 1), 0.04, 1e-9);
  EXPECT_LT(shares[2].norm(), 1e-12) << "it lies behind the node";
}

TEST(EdgeShares, AreZeroOfWhatDoesNotCount) {
  PoseGraph graph = Chain();
  ASSERT_OK_AND_ASSIGN(const auto of_held, EdgeShares(graph, {10}, 10));
  for (const Eigen::Matrix3d& share : of_held) EXPECT_EQ(share.norm(), 0.0);
  graph.edges.push_back(graph.edges.front());
  graph.edges.back().enabled = false;
  graph.nodes.push_back({.id = 20, .T_world_node = {}});
  graph.nodes.push_back({.id = 21, .T_world_node = {}});
  graph.edges.push_back({.from = 20, .to = 21, .T_from_to = {}});
  ASSERT_OK_AND_ASSIGN(const auto shares, EdgeShares(graph, {10}, 13));
  EXPECT_EQ(shares[3].norm(), 0.0) << "disabled";
  EXPECT_EQ(shares[4].norm(), 0.0) << "another component";
  EXPECT_GT(shares[2].norm(), 0.0);
}

TEST(EdgeShares, NamesAnUnknownNode) {
  EXPECT_STATUS(EdgeShares(Chain(), {10}, 99), absl::StatusCode::kInvalidArgument, "pose graph: there is no node 99");
}

}  // namespace
}  // namespace enfilade::optimize
