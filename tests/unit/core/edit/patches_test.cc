// SPDX-License-Identifier: Apache-2.0
#include "core/edit/patches.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "tests/support/status_assertions.h"
#include "tests/unit/core/edit/covered_cells.h"
#include "tests/unit/core/edit/random_edits.h"

namespace enfilade::edit {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using Drawing = std::vector<std::string>;
using grid::CellClass;

// A map of letters as in OverlayIn, whose lower-left cell is (column, row).
struct ShownMap {
  CellBox box;
  Overlay cells;

  ShownMap(const Drawing& picture, int column, int row)
      : box{column, row, static_cast<int>(picture[0].size()), static_cast<int>(picture.size())},
        cells(OverlayIn(picture, column, row)) {}

  ClassAt classes() const {
    return [this](int column, int row) {
      EXPECT_TRUE(box.contains(column, row)) << column << ", " << row << " is asked for, outside of the map";
      const Instruction shown = cells.At(column, row);
      if (shown == Instruction::kFree) return CellClass::kFree;
      return shown == Instruction::kOccupied ? CellClass::kOccupied : CellClass::kUnknown;
    };
  }
};

const CellBox kEverywhere{-1'000'000, -1'000'000, 2'000'000, 2'000'000};

TEST(FilledCells, StopAtOtherClassesAndAtCorners) {
  const ShownMap map({"--#---",  //
                      "-#----",  //
                      "--##--",  //
                      "-----#",  //
                      "----#-"},
                     -3, 254);
  ASSERT_OK_AND_ASSIGN(const Patch filled, FilledCells(Centre(-3, 258), kEverywhere, map.box, map.classes()));
  EXPECT_EQ(PictureOf(filled, map.box), (Drawing{"##.###", "#.####", "##..##", "#####.", "####.."}));
  ASSERT_OK_AND_ASSIGN(const Patch corner, FilledCells(Centre(2, 254), kEverywhere, map.box, map.classes()));
  EXPECT_EQ(corner, (Patch{{2, 254, 1, 1}, {0, 1}}));
  ASSERT_OK_AND_ASSIGN(const Patch wall, FilledCells(Centre(-1, 256), kEverywhere, map.box, map.classes()));
  EXPECT_EQ(wall, (Patch{{-1, 256, 2, 1}, {0, 2}}));
}

TEST(FilledCells, StayWithinTheBoundsAndTheMap) {
  const ShownMap map({"......", "......", "......"}, 0, 0);
  ASSERT_OK_AND_ASSIGN(const Patch all, FilledCells({0, 0}, kEverywhere, map.box, map.classes()));
  EXPECT_EQ(all, (Patch{map.box, {0, 18}}));
  ASSERT_OK_AND_ASSIGN(const Patch some, FilledCells(Centre(2, 1), {1, -5, 3, 7}, map.box, map.classes()));
  EXPECT_EQ(some, (Patch{{1, 0, 3, 2}, {0, 6}}));
}

TEST(FilledCells, RefuseASeedOutside) {
  const ShownMap map({"-"}, 0, 0);
  EXPECT_STATUS(FilledCells(Centre(1, 0), kEverywhere, map.box, map.classes()), absl::StatusCode::kInvalidArgument,
                HasSubstr("seed"));
  EXPECT_CODE(FilledCells(Centre(0, 0), {3, 3, 5, 5}, map.box, map.classes()), absl::StatusCode::kInvalidArgument);
  EXPECT_CODE(FilledCells({-1, 0}, kEverywhere, map.box, map.classes()), absl::StatusCode::kInvalidArgument);
  constexpr int kMost = std::numeric_limits<int>::max();
  EXPECT_CODE(FilledCells(Centre(0, 0), {kMost, kMost, kMost, kMost}, map.box, map.classes()),
              absl::StatusCode::kInvalidArgument);
  ASSERT_OK_AND_ASSIGN(const Patch filled, FilledCells(Centre(0, 0), {0, 0, kMost, kMost}, map.box, map.classes()));
  EXPECT_EQ(filled, (Patch{{0, 0, 1, 1}, {0, 1}}));
}

TEST(FilledCells, RefuseMoreThanOneEditMayHave) {
  const CellBox box{-5000, -5000, 2001, 2000};
  const auto free = [](int, int) { return CellClass::kFree; };
  EXPECT_STATUS(FilledCells(Centre(-4000, -4000), kEverywhere, box, free), absl::StatusCode::kInvalidArgument,
                AllOf(HasSubstr("4000000"), HasSubstr("outline")));
  EXPECT_OK(FilledCells(Centre(-4000, -4000), {-5000, -5000, 2000, 2000}, box, free));
}

TEST(CellsWhere, AreThoseThatShowAClass) {
  const ShownMap map({"#-.-", "-##.", "...-"}, -2, -1);
  const Shape shape = Polygon{{{{-512, -256}, {256, -256}, {256, 512}, {-512, 512}}}};  // the three left columns
  ASSERT_OK_AND_ASSIGN(const Patch free, CellsWhere(shape, {CellClass::kFree}, map.box, map.classes()));
  EXPECT_EQ(PictureOf(free, map.box), (Drawing{".#..", "#...", "...."}));
  ASSERT_OK_AND_ASSIGN(const Patch known,
                       CellsWhere(shape, {CellClass::kFree, CellClass::kOccupied}, map.box, map.classes()));
  EXPECT_EQ(PictureOf(known, map.box), (Drawing{"##..", "###.", "...."}));
}

TEST(CellsWhere, RefuseShapesWithoutSuchACell) {
  const ShownMap map({"--", "--"}, 0, 0);
  EXPECT_STATUS(CellsWhere(Line{Centres({{0, 0}, {1, 1}})}, {CellClass::kOccupied}, map.box, map.classes()),
                absl::StatusCode::kInvalidArgument, HasSubstr("only_where"));
  EXPECT_STATUS(CellsWhere(Line{Centres({{5, 5}})}, {CellClass::kFree}, map.box, map.classes()),
                absl::StatusCode::kInvalidArgument, HasSubstr("outside"));
}

TEST(CellsWhere, AreTheShapesCellsWithinTheMap) {
  std::mt19937 random(3);
  for (int trial = 0; trial < 300; ++trial) {
    const CellBox box{-20, -30, 40, 50};
    Overlay cells;
    for (int i = 0; i < 30; ++i) {
      cells.Draw({Instruction::kOccupied, RandomShapes{{0, 0}, 9'000, 1'500}.RandomShape(random), false});
    }
    const Shape shape = RandomShapes{{0, 0}, 5'000, 5'000}.RandomShape(random);
    CellSet expected;
    for (const auto& [column, row] : CoveredCells(shape)) {
      if (box.contains(column, row) && cells.At(column, row) == Instruction::kOccupied) expected.emplace(column, row);
    }
    const absl::StatusOr<Patch> found = CellsWhere(shape, {CellClass::kOccupied}, box, [&](int column, int row) {
      return cells.At(column, row) == Instruction::kOccupied ? CellClass::kOccupied : CellClass::kFree;
    });
    ASSERT_EQ(found.ok(), !expected.empty()) << trial;
    if (!found.ok()) continue;
    EXPECT_OK(Validate(*found));
    EXPECT_TRUE(DrawnCells(*found) == expected) << trial;
  }
}

TEST(PatchOf, HasTheMarkedCellsOfTheBox) {
  std::mt19937 random(6);
  for (int trial = 0; trial < 300; ++trial) {
    Overlay marks;
    for (int i = 0; i < 5; ++i) {
      marks.Draw({RandomInstruction(random), RandomShapes{{0, 0}, 60'000, 20'000}.RandomShape(random), false});
    }
    const CellBox box{static_cast<int>(random() % 300) - 300, static_cast<int>(random() % 300) - 300,
                      1 + static_cast<int>(random() % 400), 1 + static_cast<int>(random() % 400)};
    const Patch patch = PatchOf(marks, box);
    EXPECT_EQ(patch.box, box);
    CellSet expected;
    for (int row = box.first_row; row < box.end_row(); ++row) {
      for (int column = box.first_column; column < box.end_column(); ++column) {
        if (marks.At(column, row) != Instruction::kNone) expected.emplace(column, row);
      }
    }
    ASSERT_TRUE(DrawnCells(patch) == expected) << trial;
    EXPECT_OK(ValidateForm(patch));
  }
}

// Runs of more cells than their numbers can count.
TEST(PatchOf, SpansBoxesOfAnySize) {
  Overlay marks;
  const std::vector<std::pair<int, int>> cells = {{-2'000'000, -2'000'000}, {1'999'999, -1'000'000}, {5, 1'999'999}};
  for (const auto& cell : cells) marks.Draw({Instruction::kFree, Line{Centres({cell})}, false});
  const Patch patch = PatchOf(marks, {-2'000'000, -2'000'000, 4'000'000, 4'000'000});
  EXPECT_OK(Validate(patch));
  EXPECT_EQ(DrawnCells(patch), CellSet(cells.begin(), cells.end()));
}

}  // namespace
}  // namespace enfilade::edit
