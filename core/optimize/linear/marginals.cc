// SPDX-License-Identifier: Apache-2.0
#include "core/optimize/linear/marginals.h"

namespace enfilade::optimize {
namespace {

std::vector<char> WithAncestors(const BlockStructure& structure, const std::vector<int>& columns) {
  std::vector<char> marked(structure.size, false);
  for (const int column : columns) {
    for (int j = column; j >= 0 && !marked[j]; j = structure.parent[j]) marked[j] = true;
  }
  return marked;
}

// One column of the inverse on the pattern of L, given all its ancestors' columns in Z.
class Recursion {
 public:
  Recursion(const BlockStructure& structure, const BlockMatrix<3>& L) : structure_(structure), L_(L) {
    Z_.diagonal.resize(structure.size);
    Z_.lower.resize(structure.row.size());
  }

  // With the unit factor U = L_kj L_jj^-1:  Z_ij = -sum_k Z_ik U_kj  and  Z_jj = (L_jj L_jj^T)^-1 - sum_k U_kj^T Z_kj.
  void AddColumn(int j) {
    const int begin = structure_.column_begin[j];
    const int end = structure_.column_begin[j + 1];
    const Eigen::Matrix3d inverse = L_.diagonal[j].triangularView<Eigen::Lower>().solve(Eigen::Matrix3d::Identity());
    std::vector<Eigen::Matrix3d>& U = unit_;
    U.clear();
    for (int p = begin; p < end; ++p) {
      U.push_back(L_.lower[p] * inverse);
      Z_.lower[p].setZero();
    }
    for (int p = begin; p < end; ++p) {
      const int k = structure_.row[p];
      Z_.lower[p] -= Z_.diagonal[k] * U[p - begin];
      // Rows of column j beyond k are all rows of column k.
      int q = p + 1;
      for (int r = structure_.column_begin[k]; q < end; ++r) {
        if (structure_.row[r] != structure_.row[q]) continue;
        Z_.lower[q] -= Z_.lower[r] * U[p - begin];
        Z_.lower[p] -= Z_.lower[r].transpose() * U[q - begin];
        ++q;
      }
    }
    Eigen::Matrix3d diagonal = inverse.transpose() * inverse;
    for (int p = begin; p < end; ++p) diagonal -= U[p - begin].transpose() * Z_.lower[p];
    Z_.diagonal[j] = 0.5 * (diagonal + diagonal.transpose());
  }

  const Eigen::Matrix3d& Diagonal(int j) const { return Z_.diagonal[j]; }

 private:
  const BlockStructure& structure_;
  const BlockMatrix<3>& L_;
  BlockMatrix<3> Z_;
  std::vector<Eigen::Matrix3d> unit_;
};

}  // namespace

std::vector<Eigen::Matrix3d> InverseDiagonal(const BlockStructure& structure, const BlockMatrix<3>& L,
                                             const std::vector<int>& wanted) {
  const std::vector<char> marked = WithAncestors(structure, wanted);
  Recursion recursion(structure, L);
  for (int j = structure.size - 1; j >= 0; --j) {
    if (marked[j]) recursion.AddColumn(j);
  }
  std::vector<Eigen::Matrix3d> blocks;
  blocks.reserve(wanted.size());
  for (const int j : wanted) blocks.push_back(recursion.Diagonal(j));
  return blocks;
}

}  // namespace enfilade::optimize
