// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <random>

#include "core/optimize/edge_error.h"
#include "core/optimize/solve_pose_graph.h"
#include "tests/support/manhattan_graph.h"
#include "tests/support/status_assertions.h"

namespace enfilade::optimize {
namespace {

// J^T Omega J of all nodes but the first, dense and from the definition.
Eigen::MatrixXd DenseInformation(const PoseGraph& graph) {
  const Eigen::Index n = 3 * static_cast<Eigen::Index>(graph.nodes.size());
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(n, n);
  for (const PoseGraphEdge& edge : graph.edges) {
    const LinearizedEdge l = LinearizeEdge(graph.nodes[edge.from].T_world_node, graph.nodes[edge.to].T_world_node,
                                           EdgeMeasurement(edge.T_from_to));
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(3, n);
    J.middleCols<3>(3 * edge.from) = l.J_from();
    J.middleCols<3>(3 * edge.to) = l.J_to;
    H += J.transpose() * edge.information * J;
  }
  return H.bottomRightCorner(n - 3, n - 3);
}

TEST(Covariance, AgreesWithTheDenseInverse) {
  PoseGraph graph = testing::MakeManhattanGraph({.nodes = 120}).graph;
  SolveOptions options;
  options.covariance_of = {119, 0, 1, 60, 119};
  ASSERT_OK_AND_ASSIGN(const SolveReport report, SolvePoseGraph(options, graph));
  ASSERT_EQ(report.covariances.size(), 5u);
  const Eigen::MatrixXd inverse = DenseInformation(graph).inverse();
  for (const NodeCovariance& node : report.covariances) {
    if (node.id == 0) {
      EXPECT_EQ(node.covariance.norm(), 0.0);  // held
      continue;
    }
    const Eigen::Matrix3d expected = inverse.block<3, 3>(3 * (node.id - 1), 3 * (node.id - 1));
    EXPECT_LT((node.covariance - expected).norm(), 1e-8 * expected.norm()) << "node " << node.id;
  }
  EXPECT_EQ(report.covariances[0].id, 119);
  EXPECT_EQ(report.covariances[0].covariance, report.covariances[4].covariance);
}

TEST(Covariance, IsTheScatterOfSolutionsOverTheMeasurementsNoise) {
  const testing::ManhattanGraph world = testing::MakeManhattanGraph({.nodes = 30, .streets = 3});
  PoseGraph solved = world.graph;
  SolveOptions options;
  options.covariance_of = {29};
  ASSERT_OK_AND_ASSIGN(const SolveReport report, SolvePoseGraph(options, solved));

  std::mt19937 random(9);
  std::normal_distribution<double> normal;
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  const int samples = 4000;
  for (int sample = 0; sample < samples; ++sample) {
    PoseGraph noisy = solved;
    for (PoseGraphEdge& edge : noisy.edges) {  // what the solution says, with an error of the stated information
      const Eigen::Matrix3d L = Eigen::Matrix3d(edge.information.inverse()).llt().matrixL();
      const Eigen::Vector3d e = L * Eigen::Vector3d(normal(random), normal(random), normal(random));
      edge.T_from_to = Between(solved.nodes[edge.from].T_world_node, solved.nodes[edge.to].T_world_node) *
                       Pose2{e.x(), e.y(), e.z()};
    }
    ASSERT_OK(SolvePoseGraph({.initialisation = Initialisation::kNone}, noisy));
    const Pose2& truth = solved.nodes[29].T_world_node;
    const Pose2& pose = noisy.nodes[29].T_world_node;
    const Eigen::Vector3d d(pose.x - truth.x, pose.y - truth.y, WrapAngle(pose.yaw - truth.yaw));
    scatter += d * d.transpose() / samples;
  }
  EXPECT_LT((report.covariances[0].covariance - scatter).norm(), 0.08 * scatter.norm());
}

TEST(Covariance, GrowsWhereALoopIsSwitchedOff) {
  PoseGraph graph = testing::MakeManhattanGraph({.nodes = 100, .streets = 4}).graph;
  SolveOptions options;
  options.covariance_of = {99};
  ASSERT_OK_AND_ASSIGN(const SolveReport with_loops, SolvePoseGraph(options, graph));
  for (PoseGraphEdge& edge : graph.edges) edge.enabled = !edge.robust;
  ASSERT_OK_AND_ASSIGN(const SolveReport without, SolvePoseGraph(options, graph));
  EXPECT_GT(without.covariances[0].covariance.trace(), 2.0 * with_loops.covariances[0].covariance.trace());
}

TEST(Covariance, OfAnUnknownNodeIsAnError) {
  PoseGraph graph = testing::MakeManhattanGraph({.nodes = 10}).graph;
  SolveOptions options;
  options.covariance_of = {10};
  EXPECT_STATUS(SolvePoseGraph(options, graph), absl::StatusCode::kInvalidArgument, ::testing::HasSubstr("no node 10"));
}

}  // namespace
}  // namespace enfilade::optimize
