// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <vector>

#include "core/optimize/linear/block_structure.h"

namespace enfilade::optimize {

// A symmetric matrix of B x B blocks, its lower triangle in elimination order: diagonal[k] is block (k, k), lower[p]
// the structure's p-th block.
template <int B>
struct BlockMatrix {
  using Block = Eigen::Matrix<double, B, B>;
  std::vector<Block> diagonal;
  std::vector<Block> lower;

  void SetZero(const BlockStructure& structure) {
    diagonal.assign(structure.size, Block::Zero());
    lower.assign(structure.row.size(), Block::Zero());
  }
};

// Replaces A by its Cholesky factor L (left-looking, by block columns). False if A is not positive definite; A is then
// undefined.
template <int B>
bool Factorize(const BlockStructure& structure, BlockMatrix<B>& A) {
  using Block = typename BlockMatrix<B>::Block;
  std::vector<int> target(structure.size);  // per row: the block in the current column
  for (int j = 0; j < structure.size; ++j) {
    const int begin = structure.column_begin[j];
    const int end = structure.column_begin[j + 1];
    for (int p = begin; p < end; ++p) target[structure.row[p]] = p;
    for (int r = structure.row_begin[j]; r < structure.row_begin[j + 1]; ++r) {
      // Column k < j has a block in row j: subtract what it contributes to column j.
      int p = structure.row_block[r];
      const Block L_jk_T = A.lower[p].transpose();
      A.diagonal[j].noalias() -= A.lower[p] * L_jk_T;
      const int last = structure.column_begin[structure.column[p] + 1];
      for (++p; p < last; ++p) A.lower[target[structure.row[p]]].noalias() -= A.lower[p] * L_jk_T;
    }
    const Eigen::LLT<Block> llt(A.diagonal[j]);
    if (llt.info() != Eigen::Success) return false;
    A.diagonal[j] = llt.matrixL();
    const Block inverse_T = A.diagonal[j].template triangularView<Eigen::Lower>().solve(Block::Identity()).transpose();
    for (int p = begin; p < end; ++p) A.lower[p] = (A.lower[p] * inverse_T).eval();
  }
  return true;
}

// Replaces b (B rows per variable, in elimination order) by the solution of L L^T x = b.
template <int B>
void SolveFactorized(const BlockStructure& structure, const BlockMatrix<B>& L, Eigen::VectorXd& b) {
  for (int j = 0; j < structure.size; ++j) {
    auto x_j = b.segment<B>(B * j);
    L.diagonal[j].template triangularView<Eigen::Lower>().solveInPlace(x_j);
    for (int p = structure.column_begin[j]; p < structure.column_begin[j + 1]; ++p) {
      b.segment<B>(B * structure.row[p]).noalias() -= L.lower[p] * x_j;
    }
  }
  for (int j = structure.size - 1; j >= 0; --j) {
    auto x_j = b.segment<B>(B * j);
    for (int p = structure.column_begin[j]; p < structure.column_begin[j + 1]; ++p) {
      x_j.noalias() -= L.lower[p].transpose() * b.segment<B>(B * structure.row[p]);
    }
    L.diagonal[j].template triangularView<Eigen::Lower>().transpose().solveInPlace(x_j);
  }
}

}  // namespace enfilade::optimize
