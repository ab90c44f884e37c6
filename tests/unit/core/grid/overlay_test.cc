// SPDX-License-Identifier: Apache-2.0
#include "core/grid/overlay.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "tests/support/status_assertions.h"

namespace enfilade::grid {
namespace {

// '.' unknown, '-' and 'f' free (the latter more certain), '+' and '#' occupied; the top row first. The lower-left cell
// at (column, row) of the lattice of 0.05 m.
OccupancyGrid Grid(const std::vector<std::string>& rows, int column = 0, int row = 0, double resolution = 0.05) {
  OccupancyGrid grid;
  grid.geometry.resolution = resolution;
  grid.geometry.T_map_grid = {column * resolution, row * resolution, 0.0};
  grid.geometry.height = static_cast<int>(rows.size());
  grid.geometry.width = static_cast<int>(rows.front().size());
  const auto value = [](char c) -> std::uint8_t {
    switch (c) {
      case '-':
        return 100;
      case 'f':
        return 10;
      case '+':
        return 150;
      case '#':
        return 250;
      default:
        return kUnknownCell;
    }
  };
  for (auto text = rows.rbegin(); text != rows.rend(); ++text) {
    for (const char c : *text) grid.cells.push_back(value(c));
  }
  return grid;
}

TEST(Overlay, PrefersKnownThenMoreCertainThenLaterCells) {
  EXPECT_EQ(*Overlay(Grid({".-f+#"}), Grid({"....."})), Grid({".-f+#"}));
  EXPECT_EQ(*Overlay(Grid({"....."}), Grid({".-f+#"})), Grid({".-f+#"}));
  EXPECT_EQ(*Overlay(Grid({"-f+#"}), Grid({"f-#+"})), Grid({"ff##"}));
  EXPECT_EQ(*Overlay(Grid({"ff##"}), Grid({"+#-f"})), Grid({"+#-f"}));
}

TEST(Overlay, IsIdempotent) {
  const OccupancyGrid grid = Grid({"#-.", "+f."}, -3, 7);
  EXPECT_EQ(*Overlay(grid, grid), grid);
}

TEST(Overlay, CoversBothGridsAndKeepsTheirPositions) {
  EXPECT_EQ(*Overlay(Grid({"#", "#"}, -2, 0), Grid({"ff"}, 0, 3)), Grid({"..ff", "....", "#...", "#..."}, -2, 0));
}

TEST(Overlay, ManyLayersAreWhatTheyAreOneByOne) {
  const std::vector<OccupancyGrid> grids = {Grid({"-f+#", "####"}), OccupancyGrid{}, Grid({"f-#+"}, -2, 1),
                                            Grid({".-", "+."}, 3, -1), Grid({"f"}, 6, 6)};
  OccupancyGrid expected;
  std::vector<const OccupancyGrid*> layers;
  for (const OccupancyGrid& grid : grids) {
    expected = Overlay(expected, grid).value();
    layers.push_back(&grid);
    EXPECT_EQ(*grid::OverlayAll(layers), expected) << layers.size();
  }
  EXPECT_TRUE(grid::OverlayAll({})->cells.empty());
}

TEST(Overlay, AnEmptyLayerChangesNothing) {
  const OccupancyGrid grid = Grid({"#-"});
  EXPECT_EQ(*Overlay(OccupancyGrid{}, grid), grid);
  EXPECT_EQ(*Overlay(grid, OccupancyGrid{}), grid);
}

TEST(ResampleToLattice, KeepsAlignedCellsAndCropsToTheKnownOnes) {
  EXPECT_EQ(*ResampleToLattice(Grid({"....", ".#-.", "...."}, 5, -9), 0.05), Grid({"#-"}, 6, -8));
  EXPECT_TRUE(ResampleToLattice(Grid({"..", ".."}), 0.05)->cells.empty());
}

TEST(ResampleToLattice, LosesNoOccupiedCellOfAFinerGrid) {
  // 0.0125 m: four cells in one.
  const OccupancyGrid fine = Grid({"ffffffff", "ffffffff", "f#ffffff", "ffffffff"}, 4, 8, 0.0125);
  EXPECT_EQ(*ResampleToLattice(fine, 0.05), Grid({"#f"}, 1, 2));
}

TEST(ResampleToLattice, FillsTheCellsOfACoarserGrid) {
  EXPECT_EQ(*ResampleToLattice(Grid({"#f"}, 1, 1, 0.10), 0.05), Grid({"##ff", "##ff"}, 2, 2));
}

TEST(ResampleToLattice, RefusesGridsThatWouldBeTooLarge) {
  OccupancyGrid far = Grid({"#"}, 0, 0, 0.03);
  far.geometry.T_map_grid.x = 1e12;
  EXPECT_CODE(ResampleToLattice(far, 0.05), absl::StatusCode::kInvalidArgument);
  EXPECT_CODE(Overlay(Grid({"#"}), Grid({"#"}, 1 << 20, 1 << 20)), absl::StatusCode::kInvalidArgument);
}

TEST(ResampleToLattice, RotatesAGridByItsOrigin) {
  OccupancyGrid turned = Grid({"#f-"});
  turned.geometry.T_map_grid = {1.0, 0.0, M_PI / 2.0};  // its columns go up along y, its rows to the left
  EXPECT_EQ(*ResampleToLattice(turned, 0.05), Grid({"-", "f", "#"}, 19, 0));
}

}  // namespace
}  // namespace enfilade::grid
