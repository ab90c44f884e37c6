// SPDX-License-Identifier: Apache-2.0
#include "core/prior/plan/plan_cells.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "tests/support/status_assertions.h"

namespace enfilade::prior {
namespace {

using Eigen::Vector2d;

grid::GridGeometry TenByTen() { return {.resolution = 0.5, .T_map_grid = {-1.0, 2.0, 0.0}, .width = 10, .height = 10}; }

std::set<std::size_t> Inside(const std::vector<Vector2d>& outline, const grid::GridGeometry& geometry) {
  std::set<std::size_t> cells;
  VisitInside(outline, geometry, [&](std::size_t cell) { cells.insert(cell); });
  return cells;
}

TEST(VisitInside, TakesCellsByTheirCentres) {
  const grid::GridGeometry geometry = TenByTen();
  const std::set<std::size_t> cells = Inside({{0.0, 3.0}, {1.0, 3.0}, {1.0, 4.6}, {0.0, 4.6}}, geometry);
  // Columns 2 and 3, rows 2 to 4: the centre of row 5 is at 4.75.
  EXPECT_EQ(cells.size(), 6u);
  EXPECT_TRUE(cells.contains(geometry.index(2, 2)));
  EXPECT_TRUE(cells.contains(geometry.index(3, 4)));
}

TEST(VisitInside, LeavesOutWhatAnLDoesNotEnclose) {
  const grid::GridGeometry geometry = TenByTen();
  const std::set<std::size_t> cells = Inside({{-1, 2}, {4, 2}, {4, 3}, {0, 3}, {0, 7}, {-1, 7}}, geometry);
  EXPECT_EQ(cells.size(), 2u * 10u + 2u * 8u);
  EXPECT_FALSE(cells.contains(geometry.index(9, 9)));
}

TEST(VisitInside, StaysOnTheGrid) {
  const grid::GridGeometry geometry = TenByTen();
  EXPECT_EQ(Inside({{-100, -100}, {100, -100}, {100, 100}, {-100, 100}}, geometry).size(), geometry.cell_count());
  EXPECT_TRUE(Inside({{50, 50}, {60, 50}, {60, 60}}, geometry).empty());
  EXPECT_TRUE(Inside({}, geometry).empty());
}

TEST(VisitInside, FollowsATurnedGrid) {
  grid::GridGeometry geometry = TenByTen();
  geometry.T_map_grid = {0.0, 0.0, M_PI / 2};  // columns count upwards, rows to the left
  EXPECT_EQ(Inside({{-0.5, 0}, {0, 0}, {0, 1}, {-0.5, 1}}, geometry),
            (std::set<std::size_t>{geometry.index(0, 0), geometry.index(1, 0)}));
}

TEST(VisitLine, LeavesNoHole) {
  const grid::GridGeometry geometry = TenByTen();
  for (const Vector2d& end : {Vector2d(3.9, 6.9), Vector2d(3.9, 2.1), Vector2d(3.9, 4.0), Vector2d(-0.9, 6.9)}) {
    std::set<std::size_t> cells;
    VisitLine({-0.9, 2.1}, end, 0.0, geometry, [&](std::size_t cell) { cells.insert(cell); });
    // Each step of a tenth of a cell is on a cell of the line, or the line could be crossed there.
    for (int step = 0; step <= 1000; ++step) {
      const Vector2d point = Vector2d(-0.9, 2.1) + (end - Vector2d(-0.9, 2.1)) * (step / 1000.0);
      const Vector2d cell = (point - Vector2d(-1.0, 2.0)) / 0.5;
      EXPECT_TRUE(cells.contains(geometry.index(static_cast<int>(cell.x()), static_cast<int>(cell.y()))));
    }
  }
}

// A room of 4 x 3 m in pixels of 0.1 m, with a door in its upper wall.
PlanGraph RoomWithDoor() {
  PlanGraph plan;
  for (const Vector2d& corner :
       {Vector2d(0, 0), Vector2d(15, 0), Vector2d(25, 0), Vector2d(40, 0), Vector2d(40, 30), Vector2d(0, 30)}) {
    plan.corners.push_back({corner});
  }
  for (const auto& [from, to] : {std::pair(0, 1), {2, 3}, {3, 4}, {4, 5}, {5, 0}}) {
    plan.walls.push_back({.from = from, .to = to});
  }
  plan.doors.push_back({.from = {15, 0}, .to = {25, 0}});
  plan.metres_per_unit = 0.1;
  return plan;
}

std::uint8_t CellAt(const grid::OccupancyGrid& raster, const Vector2d& point) {
  const Vector2d cell = (Inverse(raster.geometry.T_map_grid) * point) / raster.geometry.resolution;
  return raster
      .cells[raster.geometry.index(static_cast<int>(std::floor(cell.x())), static_cast<int>(std::floor(cell.y())))];
}

TEST(RasterOf, HasFreeRoomsAndDoorsBetweenWalls) {
  ASSERT_OK_AND_ASSIGN(const grid::OccupancyGrid raster, RasterOf(RoomWithDoor(), 0.05, 0.15));
  const std::uint8_t free = grid::CellFromProbability(0.0);
  const std::uint8_t wall = grid::CellFromProbability(1.0);
  EXPECT_EQ(CellAt(raster, {2.0, -1.5}), free);
  EXPECT_EQ(CellAt(raster, {0.7, 0.0}), wall);
  EXPECT_EQ(CellAt(raster, {0.03, -1.5}), wall);
  EXPECT_EQ(CellAt(raster, {2.0, 0.0}), free) << "the door";
  EXPECT_EQ(CellAt(raster, {2.0, 0.3}), grid::kUnknownCell) << "outside";
  EXPECT_EQ(CellAt(raster, {4.4, -3.4}), grid::kUnknownCell);
}

TEST(RasterOf, OpensDoorsThatAreDrawnOnAWall) {
  PlanGraph plan = RoomWithDoor();
  plan.walls.push_back({.from = 1, .to = 2});
  ASSERT_OK_AND_ASSIGN(const grid::OccupancyGrid raster, RasterOf(plan, 0.05, 0.15));
  EXPECT_EQ(CellAt(raster, {2.0, 0.0}), grid::CellFromProbability(0.0));
  EXPECT_EQ(CellAt(raster, {1.45, 0.0}), grid::CellFromProbability(1.0));
}

TEST(RasterOf, RefusesWhatHasNoSize) {
  PlanGraph plan = RoomWithDoor();
  plan.metres_per_unit = std::nullopt;
  EXPECT_CODE(RasterOf(plan, 0.05, 0.15), absl::StatusCode::kInvalidArgument);
  plan = RoomWithDoor();
  plan.metres_per_unit = 1e4;
  EXPECT_CODE(RasterOf(plan, 0.05, 0.15), absl::StatusCode::kInvalidArgument);
  plan = RoomWithDoor();
  plan.walls.clear();
  EXPECT_CODE(RasterOf(plan, 0.05, 0.15), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace enfilade::prior
