// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/edit/map_edit.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/core/edit/covered_cells.h"
#include "tests/unit/core/edit/random_edits.h"

namespace enfilade::edit {
namespace {

using Art = std::vector<std::string>;

const Lattice kStandard{0.05, {}};

TEST(OnLattice, TheSameLatticeChangesNothing) {
  std::mt19937 random(1);
  for (int i = 0; i < 100; ++i) {
    const Shape shape = RandomShapes{{9'000, -70'000}}.RandomShape(random);
    EXPECT_EQ(OnLattice(shape, {0.1, {1, 2, 3}}, {0.1, {1, 2, 3}}), shape);
  }
}

TEST(OnLattice, MovesByWholeCells) {
  const Lattice moved{0.05, {-0.5, 0.25, 0.0}};  // its cell (10, -5) is the other one's (0, 0)
  EXPECT_EQ(OnLattice(Brush{{{1, 2}, {-300, 77}}, 99}, kStandard, moved),
            Shape(Brush{{{1 + 2560, 2 - 1280}, {-300 + 2560, 77 - 1280}}, 99}));
  std::mt19937 random(2);
  for (int i = 0; i < 200; ++i) {
    const Shape shape = RandomShapes{{-2'000, 3'000}}.RandomShape(random);
    CellSet expected;
    for (const auto& [column, row] : DrawnCells(shape)) expected.emplace(column + 10, row - 5);
    ASSERT_TRUE(DrawnCells(OnLattice(shape, kStandard, moved)) == expected) << i;
  }
}

TEST(OnLattice, QuarterTurnsKeepCells) {
  const Lattice turned{0.05, {1.0, 0.0, M_PI / 2}};  // its x axis goes up
  EXPECT_EQ(PictureOf(OnLattice(Patch{{0, 0, 3, 2}, {0, 1, 2, 1}}, kStandard, turned), {0, 18, 2, 3}),
            (Art{"..", "##", ".."}));
  std::mt19937 random(3);
  for (int i = 0; i < 200; ++i) {
    const Patch patch = RandomShapes{{-2'000, 3'000}}.RandomPatch(random);
    CellSet expected;
    for (const auto& [column, row] : DrawnCells(patch)) expected.emplace(row, 20 - 1 - column);
    ASSERT_TRUE(DrawnCells(OnLattice(patch, kStandard, turned)) == expected) << i;
  }
}

TEST(OnLattice, ScalesLengths) {
  const Lattice fine{0.025, {}};
  EXPECT_EQ(OnLattice(Brush{{{100, -100}}, 300}, kStandard, fine), Shape(Brush{{{200, -200}}, 600}));
  EXPECT_EQ(OnLattice(Brush{{{100, -100}}, 300}, fine, kStandard), Shape(Brush{{{50, -50}}, 150}));
  EXPECT_EQ(OnLattice(Polygon{{{{0, 0}, {100, 0}, {0, 100}}}}, kStandard, fine),
            Shape(Polygon{{{{0, 0}, {200, 0}, {0, 200}}}}));
  EXPECT_EQ(PictureOf(OnLattice(Patch{{0, 0, 2, 2}, {0, 1, 2, 1}}, kStandard, fine), {-1, -1, 6, 6}),
            (Art{"......", "...##.", "...##.", ".##...", ".##...", "......"}));
  EXPECT_EQ(std::get<Brush>(OnLattice(Brush{{{0, 0}}, kMaxRadius}, kStandard, fine)).radius, kMaxRadius);
}

// Points come back to within a rounding, and so do the cells of a patch if the lattice in between is finer.
TEST(OnLattice, ThereAndBackIsTheSame) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (int i = 0; i < 300; ++i) {
    const Lattice other{0.02 + 0.01 * unit(random), {30 * unit(random), 30 * unit(random), 3 * unit(random)}};
    const Line line = RandomShapes{{-2'000, 3'000}}.RandomLine(random);
    const Shape back = OnLattice(OnLattice(line, kStandard, other), other, kStandard);
    for (std::size_t p = 0; p < line.points.size(); ++p) {
      EXPECT_NEAR(std::get<Line>(back).points[p].x, line.points[p].x, 1.3);
      EXPECT_NEAR(std::get<Line>(back).points[p].y, line.points[p].y, 1.3);
    }
    const Patch patch = RandomShapes{{-2'000, 3'000}}.RandomPatch(random);
    ASSERT_TRUE(DrawnCells(OnLattice(OnLattice(patch, kStandard, other), other, kStandard)) == DrawnCells(patch)) << i;
  }
}

// Each new cell's centre lies in one of the patch's cells, and no such cell is left out.
TEST(OnLattice, PatchesKeepTheirGround) {
  std::mt19937 random(6);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (int i = 0; i < 100; ++i) {
    const Lattice other{0.06 + 0.04 * unit(random), {unit(random), unit(random), 3 * unit(random)}};
    const Patch patch = RandomShapes{{-60'000, 65'000}}.RandomPatch(random);
    const CellSet before = DrawnCells(patch);
    const Shape changed = OnLattice(patch, kStandard, other);
    EXPECT_OK(ValidateForm(changed));
    const CellSet after = DrawnCells(changed);
    const CellBox box = std::get<Patch>(changed).box;
    for (int row = box.first_row - 3; row < box.end_row() + 3; ++row) {
      for (int column = box.first_column - 3; column < box.end_column() + 3; ++column) {
        const Eigen::Vector2d centre((column + 0.5) * other.resolution, (row + 0.5) * other.resolution);
        const Eigen::Vector2d in_map = other.T_map_lattice * centre;
        const std::pair<int, int> cell(static_cast<int>(std::floor(in_map.x() / 0.05)),
                                       static_cast<int>(std::floor(in_map.y() / 0.05)));
        ASSERT_EQ(after.contains({column, row}), before.contains(cell)) << i << ": " << column << ", " << row;
      }
    }
  }
}

// A patch with few cells in an enormous box takes no longer than its cells.
TEST(OnLattice, LargeBoxesAreNoWork) {
  Patch patch{{-2'000'000, -2'000'000, 4'000'000, 4'000'000}, {0, 1}};
  patch.runs.insert(patch.runs.end(), {0xFFFFFFFF, 0, 0xFFFFFFFF, 1, 3, 4});
  ASSERT_OK(Validate(patch));
  const Lattice moved{0.05, {0.05, 0.0, 0.0}};
  const CellSet before = DrawnCells(patch);
  CellSet expected;
  for (const auto& [column, row] : before) expected.emplace(column - 1, row);
  EXPECT_EQ(before.size(), 6U);
  EXPECT_EQ(DrawnCells(OnLattice(patch, kStandard, moved)), expected);
}

TEST(OnLattice, CellsMuchSmallerThanNewOnesMayVanish) {
  const Shape changed = OnLattice(Patch{{0, 0, 1, 1}, {0, 1}}, kStandard, {1.0, {}});
  EXPECT_TRUE(DrawnCells(changed).empty());
  EXPECT_OK(ValidateForm(changed));
}

}  // namespace
}  // namespace enfilade::edit
