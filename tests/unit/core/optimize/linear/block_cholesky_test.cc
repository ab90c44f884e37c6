// SPDX-License-Identifier: Apache-2.0
#include "core/optimize/linear/block_cholesky.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <random>

#include "core/optimize/linear/marginals.h"

namespace enfilade::optimize {
namespace {

// A random sparse symmetric positive definite matrix as blocks and as a dense matrix, in elimination order.
template <int B>
struct RandomSystem {
  explicit RandomSystem(int size, std::uint32_t seed) {
    std::mt19937 random(seed);
    std::uniform_int_distribution<int> any(0, size - 1);
    std::normal_distribution<double> normal;
    std::vector<std::pair<int, int>> pairs;
    for (int i = 1; i < size; ++i) pairs.emplace_back(i, i - 1);
    for (int k = 0; k < size; ++k) {
      const int a = any(random);
      const int b = any(random);
      if (a != b) pairs.emplace_back(a, b);
    }
    structure = AnalyzeBlocks(size, pairs);
    blocks.SetZero(structure);
    dense = Eigen::MatrixXd::Zero(B * size, B * size);
    const auto fill = [&](double) { return normal(random); };
    for (const auto& [a, b] : pairs) {
      const auto [low, high] = std::minmax(structure.position[a], structure.position[b]);
      const Eigen::Matrix<double, B, 2 * B> J = Eigen::Matrix<double, B, 2 * B>::Zero().unaryExpr(fill);
      const auto J_low = J.template leftCols<B>();
      const auto J_high = J.template rightCols<B>();
      blocks.diagonal[low] += J_low.transpose() * J_low;
      blocks.diagonal[high] += J_high.transpose() * J_high;
      blocks.lower[structure.Block(high, low)] += J_high.transpose() * J_low;
    }
    for (int j = 0; j < size; ++j) {
      blocks.diagonal[j] += 0.1 * Eigen::Matrix<double, B, B>::Identity();
      dense.template block<B, B>(B * j, B * j) = blocks.diagonal[j];
    }
    for (std::size_t p = 0; p < structure.row.size(); ++p) {
      const int i = B * structure.row[p];
      const int j = B * structure.column[p];
      dense.template block<B, B>(i, j) = blocks.lower[p];
      dense.template block<B, B>(j, i) = blocks.lower[p].transpose();
    }
  }

  BlockStructure structure;
  BlockMatrix<B> blocks;
  Eigen::MatrixXd dense;
};

template <int B>
void ExpectSolvesAsDense() {
  RandomSystem<B> system(60, 7);
  Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(60 * B, -1.0, 2.0);
  const Eigen::VectorXd expected = system.dense.lu().solve(b);
  ASSERT_TRUE(Factorize(system.structure, system.blocks));
  SolveFactorized(system.structure, system.blocks, b);
  EXPECT_LT((b - expected).norm(), 1e-9 * expected.norm());
}

TEST(BlockCholesky, SolvesAsDenseEliminationDoes) {
  ExpectSolvesAsDense<2>();
  ExpectSolvesAsDense<3>();
}

TEST(BlockCholesky, RefusesAMatrixThatIsNotPositiveDefinite) {
  RandomSystem<3> system(20, 3);
  system.blocks.diagonal[11](1, 1) -= 1e3;
  EXPECT_FALSE(Factorize(system.structure, system.blocks));
}

TEST(BlockCholesky, OrdersAChainWithoutFill) {
  std::vector<std::pair<int, int>> chain;
  for (int i = 1; i < 100; ++i) chain.emplace_back(i, i - 1);
  EXPECT_EQ(AnalyzeBlocks(100, chain).row.size(), 99u);
}

TEST(BlockCholesky, AcceptsNoVariablesAndOne) {
  EXPECT_EQ(AnalyzeBlocks(0, {}).size, 0);
  const BlockStructure one = AnalyzeBlocks(1, {});
  BlockMatrix<3> A;
  A.SetZero(one);
  A.diagonal[0] = 4.0 * Eigen::Matrix3d::Identity();
  ASSERT_TRUE(Factorize(one, A));
  Eigen::VectorXd b = Eigen::VectorXd::Constant(3, 8.0);
  SolveFactorized(one, A, b);
  EXPECT_NEAR(b[2], 2.0, 1e-15);
}

TEST(InverseDiagonal, AgreesWithTheDenseInverse) {
  RandomSystem<3> system(60, 11);
  const Eigen::MatrixXd inverse = system.dense.inverse();
  ASSERT_TRUE(Factorize(system.structure, system.blocks));
  for (const std::vector<int>& wanted : {std::vector<int>{0, 17, 59, 30, 17}, std::vector<int>{3}}) {
    const std::vector<Eigen::Matrix3d> blocks = InverseDiagonal(system.structure, system.blocks, wanted);
    ASSERT_EQ(blocks.size(), wanted.size());
    for (std::size_t k = 0; k < wanted.size(); ++k) {
      const Eigen::Matrix3d expected = inverse.block<3, 3>(3 * wanted[k], 3 * wanted[k]);
      EXPECT_LT((blocks[k] - expected).norm(), 1e-9 * expected.norm()) << "column " << wanted[k];
    }
  }
}

}  // namespace
}  // namespace enfilade::optimize
