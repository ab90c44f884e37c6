// SPDX-License-Identifier: Apache-2.0
// Places that several maps know belong to one of them.
#include "core/plot/territories.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace enfilade::plot {
namespace {

constexpr double kResolution = 0.5;

// Rows from the top: '#' wall, '.' free, ' ' unknown. The lower left corner is the frame's origin.
grid::OccupancyGrid Drawn(const std::vector<std::string>& rows) {
  grid::OccupancyGrid grid;
  grid.geometry.resolution = kResolution;
  grid.geometry.width = static_cast<int>(rows[0].size());
  grid.geometry.height = static_cast<int>(rows.size());
  for (auto row = rows.rbegin(); row != rows.rend(); ++row) {
    for (const char c : *row) grid.cells.push_back(c == '#' ? 255 : (c == '.' ? 1 : grid::kUnknownCell));
  }
  return grid;
}

std::vector<std::string> Text(const grid::OccupancyGrid& grid) {
  std::vector<std::string> rows;
  for (int row = grid.geometry.height - 1; row >= 0; --row) {
    rows.emplace_back();
    for (int column = 0; column < grid.geometry.width; ++column) {
      const std::uint8_t cell = grid.cells[grid.geometry.index(column, row)];
      rows.back() += cell == grid::kUnknownCell ? ' ' : (cell > 128 ? '#' : '.');
    }
  }
  return rows;
}

Eigen::Vector2d CentreOf(int column, int row_from_below) {
  return kResolution * Eigen::Vector2d(column + 0.5, row_from_below + 0.5);
}

using Rows = std::vector<std::string>;

// Two rooms and a door. Each map knows much of the other one's room.
const Rows kLeft = {"#####    ",  //
                    "#...#    ",  //
                    "#......  ",  //
                    "#...#..  ",  //
                    "#####    "};
const Rows kRight = {"    #####",  //
                     "    #...#",  //
                     " .......#",  //
                     " ...#...#",  //
                     "    #####"};

TEST(Territories, WhatIsSeenThroughADoorBelongsToTheMapThatRobotsDroveInThere) {
  const std::vector<SceneRaster> cut = CutToTerritories(
      {{{Drawn(kLeft), {}, grid::kRed}, {CentreOf(2, 2)}}, {{Drawn(kRight), {}, grid::kBlue}, {CentreOf(6, 2)}}}, {});
  ASSERT_EQ(cut.size(), 2U);
  EXPECT_EQ(cut[0].color, grid::kRed);
  // The drives are equally far from the door, whose ground is the first map's. So are its jambs, which both know.
  EXPECT_EQ(Text(cut[0].grid), (Rows{"#####    ", "#...#    ", "#....    ", "#...#    ", "#####    "}));
  EXPECT_EQ(Text(cut[1].grid), (Rows{"     ####", "     ...#", "     ...#", "     ...#", "     ####"}));
}

TEST(Territories, AreTheSameInTurnedAndShiftedFrames) {
  const Pose2 T_scene_map{3.0, -2.0, 2.0};
  const Pose2 T_scene_other{-4.0, 7.0, -0.7};
  grid::OccupancyGrid right = Drawn(kRight);
  right.geometry.T_map_grid = Inverse(T_scene_other) * T_scene_map;
  const auto in_scene = [&](int column, int row) { return T_scene_map * CentreOf(column, row); };
  const std::vector<SceneRaster> cut = CutToTerritories(
      {{{Drawn(kLeft), T_scene_map, {}}, {in_scene(2, 2)}}, {{right, T_scene_other, {}}, {in_scene(6, 2)}}}, {});
  // Far from the border, that of the lattice does not matter.
  for (const auto& [column, row, owner] : {std::tuple{1, 3, 0}, {2, 1, 0}, {6, 3, 1}, {6, 1, 1}, {5, 2, 1}}) {
    const std::size_t index = cut[0].grid.geometry.index(column, row);
    EXPECT_EQ(cut[0].grid.cells[index] != grid::kUnknownCell, owner == 0) << column << ", " << row;
    EXPECT_EQ(cut[1].grid.cells[index] != grid::kUnknownCell, owner == 1) << column << ", " << row;
  }
}

TEST(Territories, DoNotReachThroughDoors) {
  // The right map's drive is far from the door, and the left one's is at it.
  const std::vector<DrivenRaster> rasters = {
      {{Drawn({".......... ", ".......... ", ".......... "}), {}, {}}, {CentreOf(2, 1)}},
      {{Drawn({"  .........", "  .........", "  ........."}), {}, {}}, {CentreOf(10, 1)}}};
  const std::vector<SceneRaster> open = CutToTerritories(rasters, {});
  EXPECT_EQ(Text(open[0].grid)[1], ".......    ");
  const std::vector<SceneRaster> closed = CutToTerritories(rasters, {CentreOf(4, 1)});
  EXPECT_EQ(Text(closed[0].grid)[1].substr(6), "     ");
  EXPECT_EQ(Text(closed[1].grid)[1].substr(6), ".....");
  EXPECT_EQ(Text(closed[0].grid)[1].substr(0, 3), "...");
}

TEST(Territories, GroundIsReachedAroundWallsNotThroughThem) {
  // The upper drive is nearer to the lower corridor, but a wall is between them.
  const Rows both = {".......", "######.", "......."};
  const std::vector<SceneRaster> cut =
      CutToTerritories({{{Drawn(both), {}, {}}, {CentreOf(0, 2)}}, {{Drawn(both), {}, {}}, {CentreOf(4, 0)}}}, {});
  EXPECT_EQ(Text(cut[0].grid)[2], "       ");
  EXPECT_EQ(Text(cut[1].grid)[2], ".......");
  EXPECT_EQ(Text(cut[0].grid)[0].substr(0, 5), ".....");
}

TEST(Territories, WhatNoDriveReachesStaysInAllMaps) {
  const Rows island = {"... ...", "... ...", "... ..."};
  const std::vector<SceneRaster> cut =
      CutToTerritories({{{Drawn(island), {}, {}}, {CentreOf(1, 1)}}, {{Drawn(island), {}, {}}, {}}}, {});
  EXPECT_EQ(Text(cut[0].grid), island);
  EXPECT_EQ(Text(cut[1].grid), (Rows{"    ...", "    ...", "    ..."}));
  const std::vector<SceneRaster> without =
      CutToTerritories({{{Drawn(island), {}, {}}, {}}, {{Drawn(island), {}, {}}, {}}}, {});
  EXPECT_EQ(Text(without[0].grid), island);
  EXPECT_EQ(Text(without[1].grid), island);
  EXPECT_TRUE(CutToTerritories({}, {}).empty());
}

TEST(Territories, MapsOfLevelsAboveEachOtherStayWhole) {
  const Rows room = {".....", ".....", "....."};
  const std::vector<SceneRaster> cut = CutToTerritories(
      {{{Drawn(room), {}, {}}, {CentreOf(1, 1)}, 0}, {{Drawn(room), {}, {}}, {CentreOf(3, 1)}, 1}}, {});
  EXPECT_EQ(Text(cut[0].grid), room);
  EXPECT_EQ(Text(cut[1].grid), room);
}

TEST(Territories, ADriveOutsideOfAllRastersIsIgnored) {
  const std::vector<SceneRaster> cut =
      CutToTerritories({{{Drawn(kLeft), {}, {}}, {Eigen::Vector2d(1e6, 0.0), Eigen::Vector2d(0.0, -1e6)}}}, {});
  EXPECT_EQ(Text(cut[0].grid), kLeft);
}

}  // namespace
}  // namespace enfilade::plot
