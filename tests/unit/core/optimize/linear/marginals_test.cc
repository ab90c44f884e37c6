// SPDX-License-Identifier: Apache-2.0
#include "core/optimize/linear/marginals.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <numeric>

#include "core/optimize/linear/normal_equations.h"
#include "tests/support/manhattan_graph.h"
#include "tests/support/status_assertions.h"

namespace enfilade::optimize {
namespace {

// The equations of a graph at its given poses, factorised, and the dense inverse in elimination order.
struct FactorizedGraph {
  GraphLayout layout;
  BlockMatrix<3> L;
  Eigen::MatrixXd inverse;

  explicit FactorizedGraph(const PoseGraph& graph, const std::vector<std::int64_t>& fixed) {
    const auto components = IndexComponents(graph, fixed);
    EXPECT_OK(components);
    const IndexedGraph& part = components->front();
    layout = LayOut(part);
    NormalEquations equations;
    Linearize(part, layout, {}, equations);
    const BlockStructure& structure = layout.structure;
    Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(3 * structure.size, 3 * structure.size);
    for (int j = 0; j < structure.size; ++j) dense.block<3, 3>(3 * j, 3 * j) = equations.H.diagonal[j];
    for (std::size_t p = 0; p < structure.row.size(); ++p) {
      const int i = 3 * structure.row[p];
      const int j = 3 * structure.column[p];
      dense.block<3, 3>(i, j) = equations.H.lower[p];
      dense.block<3, 3>(j, i) = equations.H.lower[p].transpose();
    }
    inverse = dense.inverse();
    L = equations.H;
    EXPECT_TRUE(Factorize(structure, L));
  }

  std::vector<int> AllColumns() const {
    std::vector<int> columns(static_cast<std::size_t>(layout.structure.size));
    std::iota(columns.begin(), columns.end(), 0);
    return columns;
  }
};

class MarginalsTest : public ::testing::TestWithParam<std::uint32_t> {
 protected:
  const FactorizedGraph graph_{testing::MakeManhattanGraph({.nodes = 50, .seed = GetParam()}).graph, {0, 17}};
};

TEST_P(MarginalsTest, EqualTheDenseInverseInEveryColumn) {
  const std::vector<int> columns = graph_.AllColumns();
  const std::vector<Eigen::Matrix3d> blocks = InverseDiagonal(graph_.layout.structure, graph_.L, columns);
  ASSERT_EQ(blocks.size(), columns.size());
  for (const int k : columns) {
    const Eigen::Matrix3d expected = graph_.inverse.block<3, 3>(3 * k, 3 * k);
    EXPECT_LT((blocks[k] - expected).norm(), 1e-9 * expected.norm()) << "column " << k;
  }
}

TEST_P(MarginalsTest, DoNotDependOnWhichOthersAreWanted) {
  const std::vector<Eigen::Matrix3d> all = InverseDiagonal(graph_.layout.structure, graph_.L, graph_.AllColumns());
  for (const int k : graph_.AllColumns()) {
    const std::vector<Eigen::Matrix3d> alone = InverseDiagonal(graph_.layout.structure, graph_.L, {k});
    ASSERT_EQ(alone.size(), 1u);
    EXPECT_EQ(alone[0], all[k]) << "column " << k;
  }
}

TEST_P(MarginalsTest, AreSymmetricAndPositive) {
  for (const Eigen::Matrix3d& block : InverseDiagonal(graph_.layout.structure, graph_.L, graph_.AllColumns())) {
    EXPECT_EQ(block, Eigen::Matrix3d(block.transpose()));
    EXPECT_GT(block.determinant(), 0.0);
    EXPECT_GT(block.diagonal().minCoeff(), 0.0);
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, MarginalsTest, ::testing::Range(1U, 6U));

TEST(Marginals, OfNothingWantedAreEmpty) {
  const FactorizedGraph graph(testing::MakeManhattanGraph({.nodes = 5}).graph, {});
  EXPECT_TRUE(InverseDiagonal(graph.layout.structure, graph.L, {}).empty());
}

// Information adds: the end of a chain of edges has the sum of the covariances, of two parallel edges half of one.
TEST(Marginals, AddAlongAChainAndHalveBetweenParallelEdges) {
  PoseGraph graph;
  for (int i = 0; i < 4; ++i) graph.nodes.push_back({i, {}});
  const Eigen::Matrix3d information = Eigen::Vector3d(100.0, 25.0, 400.0).asDiagonal();
  for (int i = 0; i < 3; ++i) graph.edges.push_back({i, i + 1, {}, information});
  const FactorizedGraph chain(graph, {0});
  for (int i = 1; i < 4; ++i) {
    const Eigen::Matrix3d block = InverseDiagonal(chain.layout.structure, chain.L, {chain.layout.position[i]})[0];
    EXPECT_LT((block - i * Eigen::Matrix3d(information.inverse())).norm(), 1e-12) << "node " << i;
  }
  graph.edges.push_back({0, 1, {}, information});
  const FactorizedGraph doubled(graph, {0});
  const Eigen::Matrix3d block = InverseDiagonal(doubled.layout.structure, doubled.L, {doubled.layout.position[1]})[0];
  EXPECT_LT((block - 0.5 * Eigen::Matrix3d(information.inverse())).norm(), 1e-12);
}

}  // namespace
}  // namespace enfilade::optimize
