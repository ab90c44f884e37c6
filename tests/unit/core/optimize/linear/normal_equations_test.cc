// SPDX-License-Identifier: Apache-2.0
#include "core/optimize/linear/normal_equations.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/support/manhattan_graph.h"
#include "tests/support/status_assertions.h"

namespace enfilade::optimize {
namespace {

// H = sum w J^T Omega J and b = -sum w J^T Omega e over all nodes, dense, from the definition.
struct DenseEquations {
  Eigen::MatrixXd H;
  Eigen::VectorXd b;

  DenseEquations(const IndexedGraph& graph, const RobustKernel& kernel) {
    const auto size = 3 * static_cast<Eigen::Index>(graph.poses.size());
    H = Eigen::MatrixXd::Zero(size, size);
    b = Eigen::VectorXd::Zero(size);
    for (const IndexedEdge& edge : graph.edges) {
      const LinearizedEdge l = LinearizeEdge(graph.poses[edge.from], graph.poses[edge.to], edge.measurement);
      const double weight = edge.robust ? Evaluate(kernel, l.error.dot(edge.information * l.error)).weight : 1.0;
      Eigen::MatrixXd J = Eigen::MatrixXd::Zero(3, size);
      J.middleCols<3>(3 * edge.from) = l.J_from();
      J.middleCols<3>(3 * edge.to) = l.J_to;
      H += weight * J.transpose() * edge.information * J;
      b -= weight * J.transpose() * edge.information * l.error;
    }
  }
};

struct EquationsCase {
  const char* name;
  RobustKernel kernel;
  std::vector<std::int64_t> fixed;
};

class NormalEquationsTest : public ::testing::TestWithParam<EquationsCase> {
 protected:
  void SetUp() override {
    PoseGraph graph = testing::MakeManhattanGraph({.nodes = 40, .outlier_share = 0.2, .seed = 4}).graph;
    // Edges in both directions between free nodes, whatever the elimination order.
    for (std::size_t k = 0; k < graph.edges.size(); k += 3) {
      PoseGraphEdge& edge = graph.edges[k];
      std::swap(edge.from, edge.to);
      edge.T_from_to = Inverse(edge.T_from_to);
    }
    ASSERT_OK_AND_ASSIGN(std::vector<IndexedGraph> components, IndexComponents(graph, GetParam().fixed));
    ASSERT_EQ(components.size(), 1u);
    graph_ = std::move(components.front());
    layout_ = LayOut(graph_);
    Linearize(graph_, layout_, GetParam().kernel, equations_);
  }

  // The node eliminated k-th.
  int NodeAt(int k) const {
    for (std::size_t i = 0; i < layout_.position.size(); ++i) {
      if (layout_.position[i] == k) return static_cast<int>(i);
    }
    ADD_FAILURE() << "no node is eliminated at " << k;
    return 0;
  }

  Eigen::VectorXd RandomStep(std::uint32_t seed, double scale) const {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    Eigen::VectorXd dx(3 * layout_.structure.size);
    for (Eigen::Index i = 0; i < dx.size(); ++i) dx[i] = scale * normal(random);
    return dx;
  }

  IndexedGraph graph_;
  GraphLayout layout_;
  NormalEquations equations_;
};

TEST_P(NormalEquationsTest, EqualTheDenseOnes) {
  const DenseEquations dense(graph_, GetParam().kernel);
  const double scale = dense.H.norm();
  const BlockStructure& structure = layout_.structure;
  for (int j = 0; j < structure.size; ++j) {
    const int node = 3 * NodeAt(j);
    EXPECT_LT((equations_.H.diagonal[j] - dense.H.block<3, 3>(node, node)).norm(), 1e-12 * scale);
    EXPECT_LT((equations_.b.segment<3>(3 * j) - dense.b.segment<3>(node)).norm(), 1e-12 * scale);
  }
  for (std::size_t p = 0; p < structure.row.size(); ++p) {
    const int row = 3 * NodeAt(structure.row[p]);
    const int column = 3 * NodeAt(structure.column[p]);
    EXPECT_LT((equations_.H.lower[p] - dense.H.block<3, 3>(row, column)).norm(), 1e-12 * scale);
  }
}

TEST_P(NormalEquationsTest, PointDownTheCost) {
  const double h = 1e-6;
  const Eigen::VectorXd direction = RandomStep(1, 1.0);
  const auto cost_at = [&](double by) {
    return GraphCost(graph_, Moved(layout_, graph_.poses, by * direction), GetParam().kernel);
  };
  const double numeric = (cost_at(h) - cost_at(-h)) / (2.0 * h);
  EXPECT_NEAR(-2.0 * equations_.b.dot(direction), numeric, 1e-5 * std::abs(numeric));
}

TEST_P(NormalEquationsTest, PredictTheDecreaseOfTheQuadraticModel) {
  const DenseEquations dense(graph_, GetParam().kernel);
  for (std::uint32_t seed = 1; seed <= 5; ++seed) {
    const Eigen::VectorXd dx = RandomStep(seed, 0.1);
    Eigen::VectorXd all = Eigen::VectorXd::Zero(dense.b.size());
    for (int k = 0; k < layout_.structure.size; ++k) all.segment<3>(3 * NodeAt(k)) = dx.segment<3>(3 * k);
    const double expected = 2.0 * dense.b.dot(all) - all.dot(dense.H * all);
    EXPECT_NEAR(PredictedDecrease(layout_.structure, equations_, dx), expected, 1e-9 * std::abs(expected));
  }
}

TEST_P(NormalEquationsTest, AreTheSameInMemoryUsedBefore) {
  NormalEquations reused;
  Linearize(graph_, layout_, {}, reused);
  Linearize(graph_, layout_, GetParam().kernel, reused);
  EXPECT_EQ(reused.b, equations_.b);
  EXPECT_EQ(reused.H.diagonal, equations_.H.diagonal);
  EXPECT_EQ(reused.H.lower, equations_.H.lower);
}

TEST_P(NormalEquationsTest, MoveFreeNodesOnly) {
  const Eigen::VectorXd dx = RandomStep(3, 2.0);
  const std::vector<Pose2> moved = Moved(layout_, graph_.poses, dx);
  for (std::size_t i = 0; i < moved.size(); ++i) {
    const Pose2& before = graph_.poses[i];
    const int k = 3 * layout_.position[i];
    if (k < 0) {
      EXPECT_TRUE(graph_.held[i]);
      EXPECT_EQ(moved[i], before);
      continue;
    }
    EXPECT_DOUBLE_EQ(moved[i].x, before.x + dx[k]);
    EXPECT_DOUBLE_EQ(moved[i].y, before.y + dx[k + 1]);
    EXPECT_LE(std::abs(moved[i].yaw), M_PI + 1e-12);
    EXPECT_NEAR(std::remainder(moved[i].yaw - before.yaw - dx[k + 2], 2.0 * M_PI), 0.0, 1e-12);
  }
}

INSTANTIATE_TEST_SUITE_P(Cases, NormalEquationsTest,
                         ::testing::Values(EquationsCase{"NoKernel", {}, {}},
                                           EquationsCase{"SeveralHeld", {}, {0, 7, 8, 39}},
                                           EquationsCase{"Huber", {RobustKernel::Type::kHuber, 1.0}, {3}},
                                           EquationsCase{"Cauchy", {RobustKernel::Type::kCauchy, 2.0}, {}},
                                           EquationsCase{"Dcs", {RobustKernel::Type::kDcs, 1.5}, {0, 20}}),
                         [](const ::testing::TestParamInfo<EquationsCase>& equations) {
                           return std::string(equations.param.name);
                         });

TEST(GraphCost, AddsTheKernelsCostsAndThePlainOnesOfEdgesThatAreNotRobust) {
  IndexedGraph graph;
  graph.poses = {{0.0, 0.0, 0.0}, {3.0, 0.0, 0.0}};
  graph.held = {true, false};
  const Eigen::Matrix3d information = 4.0 * Eigen::Matrix3d::Identity();
  graph.edges.push_back({0, 1, true, EdgeMeasurement({1.0, 0.0, 0.0}), information});    // chi2 4 * 2^2 = 16
  graph.edges.push_back({0, 1, false, EdgeMeasurement({2.5, 0.0, 0.0}), information});   // chi2 4 * 0.5^2 = 1
  graph.edges.push_back({1, 0, false, EdgeMeasurement({-3.0, 0.0, 0.0}), information});  // 0
  EXPECT_DOUBLE_EQ(GraphCost(graph, graph.poses, {}), 17.0);
  // Huber of width 2: 2 * 2 * sqrt(16) - 4.
  EXPECT_DOUBLE_EQ(GraphCost(graph, graph.poses, {RobustKernel::Type::kHuber, 2.0}), 12.0 + 1.0);
  EXPECT_DOUBLE_EQ(GraphCost(graph, {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}}, {}), 0.0 + 9.0 + 16.0);
}

}  // namespace
}  // namespace enfilade::optimize
