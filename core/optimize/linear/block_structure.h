// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>
#include <vector>

namespace enfilade::optimize {

// Which blocks the Cholesky factor L of a symmetric block matrix has, for blocks of any size: found once, used for
// every factorisation (Davis 2006, Direct Methods for Sparse Linear Systems, chapters 4 and 7). Rows and columns are in
// elimination order (approximate minimum degree); `position` and `order` translate.
struct BlockStructure {
  int size = 0;
  std::vector<int> order;     // the variable eliminated k-th
  std::vector<int> position;  // per variable: when it is eliminated
  std::vector<int> parent;    // per column: its parent in the elimination tree, or -1

  // Blocks strictly below the diagonal: those of column j are [column_begin[j], column_begin[j + 1]), rows ascending.
  std::vector<int> column_begin;
  std::vector<int> row;
  std::vector<int> column;  // of each of them

  // The same blocks by rows: [row_begin[i], row_begin[i + 1]) index `row_block`, whose entries index `row`.
  std::vector<int> row_begin;
  std::vector<int> row_block;

  // The index of block (i, j), which must exist: i > j, in elimination order.
  int Block(int i, int j) const;
};

// Of a matrix of `size` variables whose blocks (a, b) and (b, a) are not zero for the pairs given (any order, repeated
// ones allowed, a != b).
BlockStructure AnalyzeBlocks(int size, const std::vector<std::pair<int, int>>& pairs);

}  // namespace enfilade::optimize
