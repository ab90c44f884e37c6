// SPDX-License-Identifier: Apache-2.0
#include "core/optimize/linear/block_structure.h"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <numeric>

namespace enfilade::optimize {
namespace {

// Rows of the lower triangle, by column.
using Columns = std::vector<std::vector<int>>;

std::vector<int> MinimumDegreeOrder(int size, const std::vector<std::pair<int, int>>& pairs) {
  std::vector<Eigen::Triplet<char>> entries;
  entries.reserve(2 * pairs.size() + size);
  for (int k = 0; k < size; ++k) entries.emplace_back(k, k, 1);  // Eigen orders variables without a diagonal last
  for (const auto& [a, b] : pairs) {
    entries.emplace_back(a, b, 1);
    entries.emplace_back(b, a, 1);
  }
  Eigen::SparseMatrix<char> pattern(size, size);
  pattern.setFromTriplets(entries.begin(), entries.end(), [](char, char b) { return b; });
  Eigen::AMDOrdering<int>::PermutationType permutation;
  Eigen::AMDOrdering<int>()(pattern, permutation);
  return {permutation.indices().begin(), permutation.indices().end()};
}

// Column j of L has the rows of the matrix's own column j and those of its children in the elimination tree.
Columns FillIn(Columns columns, std::vector<int>& parent) {
  const int size = static_cast<int>(columns.size());
  parent.assign(size, -1);
  for (int j = 0; j < size; ++j) {
    std::vector<int>& rows = columns[j];
    std::sort(rows.begin(), rows.end());
    rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
    if (rows.empty()) continue;
    parent[j] = rows.front();
    std::vector<int>& above = columns[parent[j]];
    above.insert(above.end(), rows.begin() + 1, rows.end());
  }
  return columns;
}

void IndexRows(BlockStructure& structure) {
  structure.row_begin.assign(structure.size + 1, 0);
  for (const int i : structure.row) ++structure.row_begin[i + 1];
  std::partial_sum(structure.row_begin.begin(), structure.row_begin.end(), structure.row_begin.begin());
  structure.row_block.resize(structure.row.size());
  std::vector<int> next(structure.row_begin.begin(), structure.row_begin.end() - 1);
  for (std::size_t block = 0; block < structure.row.size(); ++block) {
    structure.row_block[next[structure.row[block]]++] = static_cast<int>(block);
  }
}

}  // namespace

int BlockStructure::Block(int i, int j) const {
  const auto begin = row.begin() + column_begin[j];
  const auto end = row.begin() + column_begin[j + 1];
  return static_cast<int>(std::lower_bound(begin, end, i) - row.begin());
}

BlockStructure AnalyzeBlocks(int size, const std::vector<std::pair<int, int>>& pairs) {
  BlockStructure structure;
  structure.size = size;
  structure.order = MinimumDegreeOrder(size, pairs);
  structure.position.resize(size);
  for (int k = 0; k < size; ++k) structure.position[structure.order[k]] = k;

  Columns columns(size);
  for (const auto& [a, b] : pairs) {
    const auto [low, high] = std::minmax(structure.position[a], structure.position[b]);
    columns[low].push_back(high);
  }
  columns = FillIn(std::move(columns), structure.parent);
  structure.column_begin.push_back(0);
  for (const std::vector<int>& rows : columns) {
    structure.row.insert(structure.row.end(), rows.begin(), rows.end());
    structure.column.resize(structure.row.size(), static_cast<int>(structure.column_begin.size()) - 1);
    structure.column_begin.push_back(static_cast<int>(structure.row.size()));
  }
  IndexRows(structure);
  return structure;
}

}  // namespace enfilade::optimize
