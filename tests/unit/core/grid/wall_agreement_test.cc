// SPDX-License-Identifier: Apache-2.0
#include "core/grid/wall_agreement.h"

#include <gtest/gtest.h>

namespace enfilade::grid {
namespace {

constexpr double kCell = 0.1;  // m

// A room of this size, m, all of it known, with its lower left corner in the map's origin.
OccupancyGrid Room(double width, double height) {
  OccupancyGrid grid;
  grid.geometry = {kCell, {}, static_cast<int>(width / kCell), static_cast<int>(height / kCell)};
  for (int row = 0; row < grid.geometry.height; ++row) {
    for (int column = 0; column < grid.geometry.width; ++column) {
      const bool wall = row == 0 || column == 0 || row + 1 == grid.geometry.height || column + 1 == grid.geometry.width;
      grid.cells.push_back(CellFromProbability(wall ? 0.9 : 0.1));
    }
  }
  return grid;
}

TEST(WallAgreement, TheSameRoomIsMatchedWhole) {
  OccupancyGrid moved = Room(4.0, 3.0);
  moved.geometry.T_map_grid = {0.1, -0.05, 0.0};
  const WallAgreement agreement = CompareWalls(Room(4.0, 3.0), moved, 0.2);
  EXPECT_GT(agreement.matched, 150);
  EXPECT_EQ(agreement.contradicted, 0);
  EXPECT_EQ(agreement.contradicted_share(), 0.0);
}

TEST(WallAgreement, ARoomThatLiesAcrossContradicts) {
  OccupancyGrid turned = Room(4.0, 3.0);
  turned.geometry.T_map_grid = {1.0, -1.0, 0.6};
  const WallAgreement agreement = CompareWalls(Room(4.0, 3.0), turned, 0.2);
  EXPECT_GT(agreement.contradicted_share(), 0.4);
  const WallAgreement other_way = CompareWalls(turned, Room(4.0, 3.0), 0.2);
  EXPECT_EQ(other_way.matched, agreement.matched);
  EXPECT_EQ(other_way.contradicted, agreement.contradicted);
}

TEST(WallAgreement, WhatOnlyOneGridKnowsSaysNothing) {
  OccupancyGrid elsewhere = Room(4.0, 3.0);
  elsewhere.geometry.T_map_grid = {10.0, 0.0, 0.3};
  EXPECT_EQ(CompareWalls(Room(4.0, 3.0), elsewhere, 0.2).contradicted_share(), 0.0);
  OccupancyGrid unseen = Room(4.0, 3.0);
  unseen.cells.assign(unseen.cells.size(), kUnknownCell);
  EXPECT_EQ(CompareWalls(Room(4.0, 3.0), unseen, 0.2).contradicted, 0);
  EXPECT_EQ(CompareWalls({}, Room(4.0, 3.0), 0.2).matched, 0);
}

TEST(WallAgreement, CellsOfAnotherSizeAreCompared) {
  OccupancyGrid coarse;
  coarse.geometry = {0.2, {}, 20, 15};
  for (int row = 0; row < 15; ++row) {
    for (int column = 0; column < 20; ++column) {
      const bool wall = row == 0 || column == 0 || row == 14 || column == 19;
      coarse.cells.push_back(CellFromProbability(wall ? 0.9 : 0.1));
    }
  }
  EXPECT_EQ(CompareWalls(Room(4.0, 3.0), coarse, 0.2).contradicted, 0);
}

}  // namespace
}  // namespace enfilade::grid
