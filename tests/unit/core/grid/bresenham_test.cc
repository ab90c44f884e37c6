// SPDX-License-Identifier: Apache-2.0
#include "core/grid/bresenham.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ostream>
#include <random>
#include <vector>

namespace enfilade::grid {

void PrintTo(const CellIndex& cell, std::ostream* os) { *os << "(" << cell.column << ", " << cell.row << ")"; }

namespace {

using ::testing::ElementsAre;

std::vector<CellIndex> LineOf(CellIndex from, CellIndex to) {
  std::vector<CellIndex> cells;
  VisitLine(from, to, [&](CellIndex cell) { cells.push_back(cell); });
  return cells;
}

TEST(Bresenham, OnePointIsOneCell) { EXPECT_THAT(LineOf({3, -4}, {3, -4}), ElementsAre(CellIndex{3, -4})); }

TEST(Bresenham, DrawsTheTextbookLine) {
  EXPECT_THAT(LineOf({0, 0}, {5, 2}), ElementsAre(CellIndex{0, 0}, CellIndex{1, 0}, CellIndex{2, 1}, CellIndex{3, 1},
                                                  CellIndex{4, 2}, CellIndex{5, 2}));
}

TEST(Bresenham, BreaksTiesUpwardsInBothDirections) {
  EXPECT_THAT(LineOf({0, 0}, {2, 1}), ElementsAre(CellIndex{0, 0}, CellIndex{1, 1}, CellIndex{2, 1}));
  EXPECT_THAT(LineOf({2, 1}, {0, 0}), ElementsAre(CellIndex{2, 1}, CellIndex{1, 1}, CellIndex{0, 0}));
  EXPECT_THAT(LineOf({0, 0}, {2, -1}), ElementsAre(CellIndex{0, 0}, CellIndex{1, 0}, CellIndex{2, -1}));
}

// All lines within a square, all octants and ties among them.
class AllLines : public ::testing::Test {
 protected:
  template <typename Check>
  void ForEachLine(Check check) {
    constexpr int kReach = 9;
    for (int dx = -kReach; dx <= kReach; ++dx) {
      for (int dy = -kReach; dy <= kReach; ++dy) check(CellIndex{4, -7}, CellIndex{4 + dx, -7 + dy});
    }
  }
};

TEST_F(AllLines, JoinBothEndsWithoutGapsOrRepeats) {
  ForEachLine([](CellIndex from, CellIndex to) {
    const std::vector<CellIndex> cells = LineOf(from, to);
    EXPECT_EQ(cells.front(), from);
    EXPECT_EQ(cells.back(), to);
    const int length = std::max(std::abs(to.column - from.column), std::abs(to.row - from.row));
    EXPECT_EQ(cells.size(), static_cast<std::size_t>(length) + 1);
    for (std::size_t i = 1; i < cells.size(); ++i) {
      const int step =
          std::max(std::abs(cells[i].column - cells[i - 1].column), std::abs(cells[i].row - cells[i - 1].row));
      EXPECT_EQ(step, 1);
    }
  });
}

TEST_F(AllLines, StayWithinHalfACellOfTheTrueLine) {
  ForEachLine([](CellIndex from, CellIndex to) {
    const double dx = to.column - from.column;
    const double dy = to.row - from.row;
    for (const CellIndex cell : LineOf(from, to)) {
      const double column = cell.column - from.column;
      const double row = cell.row - from.row;
      if (std::abs(dx) >= std::abs(dy)) {
        EXPECT_LE(std::abs(row - (dx == 0 ? 0 : column * dy / dx)), 0.5 + 1e-12);
      } else {
        EXPECT_LE(std::abs(column - row * dx / dy), 0.5 + 1e-12);
      }
    }
  });
}

TEST_F(AllLines, AreTheSameBackwards) {
  ForEachLine([](CellIndex from, CellIndex to) {
    std::vector<CellIndex> backwards = LineOf(to, from);
    std::reverse(backwards.begin(), backwards.end());
    EXPECT_EQ(LineOf(from, to), backwards);
  });
}

TEST_F(AllLines, AreTheSameAsOffsets) {
  ForEachLine([](CellIndex from, CellIndex to) {
    constexpr std::ptrdiff_t kStride = 64;
    const auto offset_of = [](CellIndex cell) { return (cell.row + 32) * kStride + cell.column + 32; };
    std::vector<std::ptrdiff_t> expected;
    for (const CellIndex cell : LineOf(from, to)) expected.push_back(offset_of(cell));
    std::vector<std::ptrdiff_t> offsets;
    VisitLineOffsets(from, to, offset_of(from), kStride, [&](std::ptrdiff_t offset) { offsets.push_back(offset); });
    EXPECT_EQ(offsets, expected);
  });
}

// Visits both ways and compares cell by cell without keeping the cells.
void ExpectSameAsOffsets(CellIndex from, CellIndex to) {
  constexpr std::ptrdiff_t kStride = 5'000'000;
  const auto offset_of = [](CellIndex cell) { return cell.row * kStride + cell.column; };
  std::vector<std::ptrdiff_t> offsets;
  VisitLineOffsets(from, to, offset_of(from), kStride, [&](std::ptrdiff_t offset) { offsets.push_back(offset); });
  std::size_t i = 0;
  bool same = true;
  VisitLine(from, to, [&](CellIndex cell) { same = same && i < offsets.size() && offsets[i++] == offset_of(cell); });
  EXPECT_TRUE(same && i == offsets.size()) << to.column << " " << to.row;
}

TEST(Bresenham, IsTheSameAsOffsetsOnLongLines) {
  std::mt19937 rng(5);
  std::uniform_int_distribution<int> coordinate(-520'000, 520'000);
  for (int i = 0; i < 50; ++i) ExpectSameAsOffsets({0, 0}, {coordinate(rng), coordinate(rng)});
  // The hardest slopes: the nearest to a tie, and to the limit of the fixed-point form.
  for (const int steps : {524'287, 524'286, 524'288, 600'000}) {
    for (const int sign : {-1, 1}) {
      ExpectSameAsOffsets({0, 0}, {steps, sign * (steps / 2)});
      ExpectSameAsOffsets({0, 0}, {steps, sign * (steps / 2 + 1)});
      ExpectSameAsOffsets({0, 0}, {steps, sign * (steps - 1)});
      ExpectSameAsOffsets({0, 0}, {sign, steps});
    }
  }
}

TEST(Bresenham, DoesNotOverflowOnLongLines) {
  const CellIndex from{-1'000'000'000, 0};
  const CellIndex to{1'000'000'000, 1'999'999'999};
  const BresenhamLine line(from, to);
  EXPECT_EQ(line.steps, 2'000'000'000);
  EXPECT_EQ(line.down, 4'000'000'000);
}

}  // namespace
}  // namespace enfilade::grid
