// SPDX-License-Identifier: Apache-2.0
#include "core/slam/matching/cell_window.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

namespace enfilade::slam {
namespace {

constexpr int kReach = 12;  // all windows lie within +- this

std::set<std::pair<int, int>> CellsOf(const CellWindow& window) {
  std::set<std::pair<int, int>> cells;
  for (int row = -kReach; row <= kReach; ++row) {
    for (int column = -kReach; column <= kReach; ++column) {
      if (window.contains(column, row)) cells.emplace(column, row);
    }
  }
  return cells;
}

class CellWindowTest : public ::testing::Test {
 protected:
  CellWindow Any() { return {{corner_(random_), corner_(random_)}, size_(random_), size_(random_)}; }

  std::mt19937 random_{1};
  std::uniform_int_distribution<int> corner_{-6, 4};
  std::uniform_int_distribution<int> size_{0, 6};
};

TEST_F(CellWindowTest, HoldsAsManyCellsAsItCounts) {
  for (int k = 0; k < 200; ++k) {
    const CellWindow w = Any();
    EXPECT_EQ(CellsOf(w).size(), w.cell_count());
    EXPECT_EQ(w.empty(), w.cell_count() == 0);
  }
}

TEST_F(CellWindowTest, IndexesItsCellsRowByRow) {
  for (int k = 0; k < 50; ++k) {
    const CellWindow w = Any();
    std::size_t expected = 0;
    for (int row = w.min.row; row < w.top(); ++row) {
      for (int column = w.min.column; column < w.right(); ++column) EXPECT_EQ(w.index(column, row), expected++);
    }
    EXPECT_EQ(expected, w.cell_count());
  }
}

TEST_F(CellWindowTest, IntersectsAsSetsDo) {
  for (int k = 0; k < 500; ++k) {
    const CellWindow a = Any();
    const CellWindow b = Any();
    std::set<std::pair<int, int>> both;
    for (const auto& cell : CellsOf(a)) {
      if (b.contains(cell.first, cell.second)) both.insert(cell);
    }
    EXPECT_EQ(CellsOf(Intersection(a, b)), both);
    EXPECT_EQ(Intersection(a, b), Intersection(b, a));
    EXPECT_TRUE(!both.empty() || Intersection(a, b) == CellWindow{}) << "empty ones are all the same";
  }
}

TEST_F(CellWindowTest, UnitesToTheSmallestWindowThatHoldsBoth) {
  for (int k = 0; k < 500; ++k) {
    const CellWindow a = Any();
    const CellWindow b = Any();
    const CellWindow both = Union(a, b);
    for (const CellWindow& part : {a, b}) {
      EXPECT_TRUE(part.empty() || Intersection(both, part) == part);
    }
    if (a.empty() || b.empty()) {
      EXPECT_EQ(both, a.empty() ? b : a);
      continue;
    }
    // Each side is one of theirs.
    EXPECT_TRUE(both.min.column == a.min.column || both.min.column == b.min.column);
    EXPECT_TRUE(both.min.row == a.min.row || both.min.row == b.min.row);
    EXPECT_TRUE(both.right() == a.right() || both.right() == b.right());
    EXPECT_TRUE(both.top() == a.top() || both.top() == b.top());
  }
}

TEST_F(CellWindowTest, DilatesOnAllSidesAndBack) {
  for (int k = 0; k < 50; ++k) {
    const CellWindow w = Any();
    const CellWindow wider = Dilated(w, 3);
    EXPECT_EQ(Dilated(wider, -3), w);
    EXPECT_TRUE(wider.contains(w.min.column - 3, w.min.row - 3));
    EXPECT_FALSE(wider.contains(w.min.column - 4, w.min.row));
    EXPECT_FALSE(wider.contains(w.right() + 3, w.min.row));
    EXPECT_EQ(WindowBetween(w.min.column, w.min.row, w.right(), w.top()), w);
  }
}

}  // namespace
}  // namespace enfilade::slam
