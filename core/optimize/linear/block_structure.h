// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>
#include <vector>

namespace enfilade::optimize {

// The block sparsity pattern of the Cholesky factor L of a symmetric block matrix, for blocks of any size: computed
// once, used for every factorisation (Davis 2006, Direct Methods for Sparse Linear Systems, chapters 4 and 7). Rows and
// columns are in elimination order (approximate minimum degree); `order` and `position` convert from and to variables.
struct BlockStructure {
  int size = 0;
  std::vector<int> order;     // the variable eliminated k-th
  std::vector<int> position;  // per variable: when it is eliminated
  std::vector<int> parent;    // per column: its parent in the elimination tree, or -1

  // Blocks strictly below the diagonal, by columns: column j holds [column_begin[j], column_begin[j + 1]), rows
  // ascending.
  std::vector<int> column_begin;
  std::vector<int> row;
  std::vector<int> column;  // of each block

  // The same blocks by rows: row i holds row_block[row_begin[i]] to row_block[row_begin[i + 1] - 1], indices of blocks.
  std::vector<int> row_begin;
  std::vector<int> row_block;

  // The index of block (i, j), which must exist: i > j, in elimination order.
  int Block(int i, int j) const;
};

// For a matrix of `size` variables with non-zero blocks (a, b) and (b, a) for the given pairs: a != b, in any order,
// repeated or not.
BlockStructure AnalyzeBlocks(int size, const std::vector<std::pair<int, int>>& pairs);

}  // namespace enfilade::optimize
