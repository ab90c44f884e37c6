// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/edit/overlay.h"
#include "tests/unit/core/edit/covered_cells.h"

namespace enfilade::edit {
namespace {

TEST(Regions, TouchOverSidesAndCorners) {
  const std::vector<Region> regions = RegionsOf(OverlayIn({
      "#..--",  //
      ".#..-",  //
      "#....",  //
      "...##",
  }));
  ASSERT_EQ(regions.size(), 3U);
  EXPECT_EQ(regions[0].box, (CellBox{3, 0, 2, 1}));
  EXPECT_EQ(regions[0].cells, 2);
  EXPECT_EQ(regions[1].box, (CellBox{0, 1, 2, 3}));
  EXPECT_EQ(regions[1].cells, 3);
  EXPECT_EQ(regions[2].box, (CellBox{3, 2, 2, 2}));
  EXPECT_EQ(regions[2].cells, 3);
}

TEST(Regions, CellsOfDifferentValuesAreApart) {
  const std::vector<Region> regions = RegionsOf(OverlayIn({"#-#", "##-"}));
  ASSERT_EQ(regions.size(), 2U);
  EXPECT_EQ(regions[0].cells, 4);
  EXPECT_EQ(regions[1].cells, 2);
}

TEST(Regions, GoOnAcrossTiles) {
  Overlay marks;
  marks.Draw({Instruction::kOccupied, Line{Centres({{-600, 300}, {600, -300}})}, false});
  marks.Draw({Instruction::kOccupied, Line{Centres({{-300, -10}, {-300, -5}})}, false});
  const std::vector<Region> regions = RegionsOf(marks);
  ASSERT_EQ(regions.size(), 2U);
  EXPECT_EQ(regions[0].box, (CellBox{-600, -300, 1201, 601}));
  EXPECT_EQ(regions[0].cells, 1201);
  EXPECT_EQ(std::pair(regions[0].column, regions[0].row), std::pair(600, -300));
  EXPECT_EQ(regions[1].box, (CellBox{-300, -10, 1, 6}));
}

// By row, then column of their first cells, wherever tiles end.
TEST(Regions, AreOrderedByTheirFirstCells) {
  Overlay marks;
  for (const auto& cell : {std::pair{300, 5}, {10, 7}, {-300, 6}, {40, -600}}) {
    marks.Draw({Instruction::kFree, Line{Centres({cell})}, false});
  }
  std::vector<std::pair<int, int>> order;
  for (const Region& region : RegionsOf(marks)) order.emplace_back(region.column, region.row);
  EXPECT_EQ(order, (std::vector<std::pair<int, int>>{{40, -600}, {300, 5}, {-300, 6}, {10, 7}}));
}

TEST(Regions, TheMapNumbersEachCell) {
  const Overlay marks = OverlayIn({"##.-", "#..-", "...."}, -2, 254);
  const RegionMap map = MapRegions(marks);
  ASSERT_EQ(map.regions.size(), 2U);
  std::size_t numbered = 0;
  for (const auto& [index, numbers] : map.numbers) {
    for (std::size_t place = 0; place < numbers.size(); ++place) {
      if (numbers[place] == 0) continue;
      ++numbered;
      const int column = index.column * 256 + static_cast<int>(place % 256);
      const int row = index.row * 256 + static_cast<int>(place / 256);
      EXPECT_TRUE(map.regions[numbers[place] - 1].box.contains(column, row));
      EXPECT_EQ(numbers[place], marks.At(column, row) == Instruction::kOccupied ? 1U : 2U);
    }
  }
  EXPECT_EQ(numbered, 5U);
}

TEST(Regions, NothingHasNone) { EXPECT_TRUE(RegionsOf(Overlay()).empty()); }

}  // namespace
}  // namespace enfilade::edit
