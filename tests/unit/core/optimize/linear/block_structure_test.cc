// SPDX-License-Identifier: Apache-2.0
#include "core/optimize/linear/block_structure.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>
#include <set>
#include <string>

namespace enfilade::optimize {
namespace {

using Pairs = std::vector<std::pair<int, int>>;

struct Topology {
  std::string name;
  int size;
  Pairs pairs;
};

Pairs RandomPairs(int size, int count, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> any(0, size - 1);
  Pairs pairs;
  while (static_cast<int>(pairs.size()) < count) {
    const int a = any(random);
    const int b = any(random);
    if (a != b) pairs.emplace_back(a, b);
  }
  return pairs;
}

std::vector<Topology> Topologies() {
  Topology chain{"Chain", 30, {}};
  for (int i = 1; i < chain.size; ++i) chain.pairs.emplace_back(i - 1, i);
  Topology star{"Star", 20, {}};
  for (int i = 1; i < star.size; ++i) star.pairs.emplace_back(i, 0);
  Topology ring = chain;
  ring.name = "Ring";
  ring.pairs.emplace_back(ring.size - 1, 0);
  Topology lattice{"Lattice", 49, {}};
  for (int i = 0; i < lattice.size; ++i) {
    if (i % 7 < 6) lattice.pairs.emplace_back(i, i + 1);
    if (i + 7 < lattice.size) lattice.pairs.emplace_back(i + 7, i);
  }
  Topology dense{"Dense", 9, {}};
  for (int i = 0; i < dense.size; ++i) {
    for (int j = 0; j < i; ++j) dense.pairs.emplace_back(i, j);
  }
  std::vector<Topology> all{
      chain, star, ring, lattice, dense, {"NoPairs", 6, {}}, {"Repeated", 3, {{0, 2}, {2, 0}, {0, 2}}}};
  for (std::uint32_t seed = 1; seed <= 6; ++seed) {
    all.push_back({"Random" + std::to_string(seed), 40, RandomPairs(40, 25 * static_cast<int>(seed), seed)});
  }
  return all;
}

class BlockStructureTest : public ::testing::TestWithParam<Topology> {
 protected:
  const BlockStructure structure_ = AnalyzeBlocks(GetParam().size, GetParam().pairs);
};

TEST_P(BlockStructureTest, OrdersEveryVariableOnce) {
  std::vector<int> sorted = structure_.order;
  std::sort(sorted.begin(), sorted.end());
  std::vector<int> expected(static_cast<std::size_t>(GetParam().size));
  std::iota(expected.begin(), expected.end(), 0);
  EXPECT_EQ(sorted, expected);
  for (int k = 0; k < structure_.size; ++k) EXPECT_EQ(structure_.position[structure_.order[k]], k);
}

// Eliminating a column joins all the rows that it has: what remains is the pattern of L, no block more and none less.
TEST_P(BlockStructureTest, HasTheBlocksOfSymbolicElimination) {
  std::vector<std::set<int>> below(static_cast<std::size_t>(structure_.size));
  for (const auto& [a, b] : GetParam().pairs) {
    const auto [low, high] = std::minmax(structure_.position[a], structure_.position[b]);
    below[low].insert(high);
  }
  for (int j = 0; j < structure_.size; ++j) {
    for (const int i : below[j]) {
      for (const int k : below[j]) {
        if (k > i) below[i].insert(k);
      }
    }
    const std::vector<int> expected(below[j].begin(), below[j].end());
    const std::vector<int> rows(structure_.row.begin() + structure_.column_begin[j],
                                structure_.row.begin() + structure_.column_begin[j + 1]);
    EXPECT_EQ(rows, expected) << "column " << j;
    EXPECT_EQ(structure_.parent[j], expected.empty() ? -1 : expected.front()) << "column " << j;
  }
}

TEST_P(BlockStructureTest, FindsItsBlocksByRowAndColumn) {
  ASSERT_EQ(structure_.column.size(), structure_.row.size());
  for (std::size_t p = 0; p < structure_.row.size(); ++p) {
    EXPECT_GT(structure_.row[p], structure_.column[p]);
    EXPECT_EQ(structure_.Block(structure_.row[p], structure_.column[p]), static_cast<int>(p));
  }
}

TEST_P(BlockStructureTest, ListsTheSameBlocksByRows) {
  ASSERT_EQ(structure_.row_begin.size(), static_cast<std::size_t>(structure_.size) + 1);
  std::vector<int> seen;
  for (int i = 0; i < structure_.size; ++i) {
    int last_column = -1;
    for (int r = structure_.row_begin[i]; r < structure_.row_begin[i + 1]; ++r) {
      const int p = structure_.row_block[r];
      EXPECT_EQ(structure_.row[p], i);
      EXPECT_GT(structure_.column[p], last_column) << "columns ascend";
      last_column = structure_.column[p];
      seen.push_back(p);
    }
  }
  std::sort(seen.begin(), seen.end());
  std::vector<int> expected(structure_.row.size());
  std::iota(expected.begin(), expected.end(), 0);
  EXPECT_EQ(seen, expected);
}

INSTANTIATE_TEST_SUITE_P(Topologies, BlockStructureTest, ::testing::ValuesIn(Topologies()),
                         [](const ::testing::TestParamInfo<Topology>& topology) { return topology.param.name; });

// Minimum degree eliminates the leaves first. In the worst order, the centre first, a star fills up completely.
TEST(BlockStructure, OrdersTreesWithoutFill) {
  for (const Topology& tree : Topologies()) {
    if (tree.name != "Chain" && tree.name != "Star") continue;
    EXPECT_EQ(AnalyzeBlocks(tree.size, tree.pairs).row.size(), tree.pairs.size()) << tree.name;
  }
}

}  // namespace
}  // namespace enfilade::optimize
