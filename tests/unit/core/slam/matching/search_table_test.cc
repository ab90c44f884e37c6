// SPDX-License-Identifier: Apache-2.0
#include "core/slam/matching/search_table.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace enfilade::slam {
namespace {

constexpr double kCellSide = 0.1;  // m
constexpr double kSigma = 0.15;    // m

LikelihoodField RandomField(std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> any(-2.0, 3.0);
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < 15; ++i) points.emplace_back(any(random), any(random));
  LikelihoodField field(kCellSide, 0.8);
  field.Add(points);
  return field;
}

class SearchTableTest : public ::testing::TestWithParam<std::uint32_t> {
 protected:
  SearchTableTest() { table_.Update(field_, field_.window()); }

  // Cells of the field and some around it.
  template <typename Visit>
  void ForEachCell(Visit visit) const {
    const CellWindow w = Dilated(field_.window(), 20);
    for (int row = w.min.row; row < w.top(); ++row) {
      for (int column = w.min.column; column < w.right(); ++column) visit(column, row);
    }
  }

  const LikelihoodField field_ = RandomField(GetParam());
  SearchTable table_{kSigma, 6};
};

TEST_P(SearchTableTest, HoldsTheGaussianOfTheDistance) {
  ForEachCell([&](int column, int row) {
    const int value = table_.ViewOf(0).At(column, row);
    if (!field_.window().contains(column, row)) {
      EXPECT_EQ(value, 0) << "outside of the field";
      return;
    }
    const double d2 = field_.squared_distances()[field_.window().index(column, row)];
    const double expected = d2 < 16.0 * kSigma * kSigma ? 255.0 * std::exp(-d2 / (2.0 * kSigma * kSigma)) : 0.0;
    EXPECT_NEAR(value, expected, 3.0) << "a table of 1,024 steps and bytes";
  });
}

// Exactly the largest of the four blocks: no less (or a search would miss the best pose), and no more (or it would be
// slow).
TEST_P(SearchTableTest, HoldsTheLargestLikelihoodOfTwoByTwoBlocks) {
  for (int level = 1; level < table_.levels(); ++level) {
    const int block = 1 << level;
    const CellWindow w = Dilated(field_.window(), 2 * block);
    for (int row = w.min.row >> level; row <= (w.top() >> level); ++row) {
      for (int column = w.min.column >> level; column <= (w.right() >> level); ++column) {
        int expected = 0;
        for (int y = row * block; y < (row + 2) * block; ++y) {
          for (int x = column * block; x < (column + 2) * block; ++x)
            expected = std::max(expected, table_.ViewOf(0).At(x, y));
        }
        ASSERT_EQ(table_.ViewOf(level).At(column, row), expected) << "level " << level << ", " << column << " " << row;
      }
    }
  }
}

TEST_P(SearchTableTest, HoldsNothingOutsideOfItsWindow) {
  for (int level = 0; level < table_.levels(); ++level) {
    const SearchTable::View view = table_.ViewOf(level);
    EXPECT_EQ(view.At(view.min.column - 1, view.min.row), 0);
    EXPECT_EQ(view.At(view.min.column + static_cast<int>(view.width), view.min.row), 0);
    EXPECT_EQ(view.At(view.min.column, view.min.row + static_cast<int>(view.height)), 0);
  }
}

TEST_P(SearchTableTest, StaysAsItIsIfNothingChanged) {
  SearchTable same = table_;
  same.Update(field_, {});
  same.Update(field_, field_.window());
  for (int level = 0; level < table_.levels(); ++level) {
    for (int row = -30; row < 40; ++row) {
      for (int column = -30; column < 40; ++column) {
        ASSERT_EQ(same.ViewOf(level).At(column, row), table_.ViewOf(level).At(column, row));
      }
    }
  }
  EXPECT_EQ(same.bytes(), table_.bytes());
}

INSTANTIATE_TEST_SUITE_P(Seeds, SearchTableTest, ::testing::Values(1U, 2U, 3U));

TEST(SearchTable, IsEmptyBeforeTheFirstUpdate) {
  const SearchTable table(kSigma, 4);
  EXPECT_EQ(table.levels(), 4);
  EXPECT_EQ(table.bytes(), 0U);
  for (int level = 0; level < 4; ++level) EXPECT_EQ(table.ViewOf(level).At(0, 0), 0);
}

}  // namespace
}  // namespace enfilade::slam
