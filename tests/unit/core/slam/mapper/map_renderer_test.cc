// SPDX-License-Identifier: Apache-2.0
#include "core/slam/mapper/map_renderer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/slam/submaps/robot_rays.h"
#include "tests/unit/core/slam/synthetic_drive.h"

namespace enfilade::slam {
namespace {

constexpr double kResolution = 0.05;

// What a scanner sees from the middle of a room of 6 m x 4 m, in the room's frame.
SubmapGrid RoomFromTheMiddle() {
  const auto walls = testing::WallsFromText({"########",  //
                                             "#      #",  //
                                             "#      #",  //
                                             "#      #",  //
                                             "#      #",  //
                                             "########"},
                                            1.0);
  const sensor::LaserScan scan =
      testing::Scan(walls, {4.0, 3.0, 0.0}, {.beams = 720, .field_of_view = 2.0 * M_PI, .range_sigma = 0.0}, 0, 1);
  SubmapGrid grid(kResolution, {});
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(grid.Insert({}, RobotRays(scan, {.max_range = 30.0, .no_return_range = 0.0})).ok());
  }
  return grid;
}

class MapRendererTest : public ::testing::Test {
 protected:
  MapRenderer Renderer() const { return {kResolution, LogOddsOptionsOf({})}; }
  void Place(MapRenderer& renderer, std::int64_t id, const Pose2& pose) const {
    renderer.Place(id, pose, [this]() -> const SubmapGrid& { return room_; });
  }

  // kUnknownCell outside.
  static std::uint8_t At(const grid::OccupancyGrid& grid, double x, double y) {
    const auto column = std::lround(std::floor((x - grid.geometry.T_map_grid.x) / kResolution));
    const auto row = std::lround(std::floor((y - grid.geometry.T_map_grid.y) / kResolution));
    if (column < 0 || row < 0 || column >= grid.geometry.width || row >= grid.geometry.height)
      return grid::kUnknownCell;
    return grid.cells[grid.geometry.index(static_cast<int>(column), static_cast<int>(row))];
  }
  static bool Occupied(const grid::OccupancyGrid& grid, double x, double y) {
    const auto cell = At(grid, x, y);
    return cell != grid::kUnknownCell && grid::ProbabilityOfCell(cell) > 0.6;
  }
  static bool Free(const grid::OccupancyGrid& grid, double x, double y) {
    const auto cell = At(grid, x, y);
    return cell != grid::kUnknownCell && grid::ProbabilityOfCell(cell) < 0.4;
  }

  const SubmapGrid room_ = RoomFromTheMiddle();
};

TEST_F(MapRendererTest, IsEmptyWhereNothingIsPlaced) {
  EXPECT_TRUE(Renderer().Render(nullptr, {}).cells.empty());
  EXPECT_EQ(Renderer().bytes(), 0U);
}

TEST_F(MapRendererTest, DrawsWallsAndSpaceWhereTheSubmapIs) {
  MapRenderer renderer = Renderer();
  Place(renderer, 0, {10.0, -20.0, M_PI / 2.0});  // the room's x is the map's y
  const grid::OccupancyGrid grid = renderer.Render(nullptr, {});
  EXPECT_TRUE(Free(grid, 10.0, -20.0));
  EXPECT_TRUE(Occupied(grid, 10.0, -20.0 + 3.0 + 0.01));  // 3 m ahead
  EXPECT_TRUE(Occupied(grid, 10.0 - 2.01, -20.0));        // 2 m to the left
  EXPECT_EQ(At(grid, 10.0, -20.0 + 4.0), grid::kUnknownCell);
  EXPECT_NEAR(grid.geometry.width * kResolution, 4.0, 0.15) << "cropped to what is known";
  EXPECT_NEAR(grid.geometry.height * kResolution, 6.0, 0.15);
}

TEST_F(MapRendererTest, GivesTheSameWhateverTheWayThere) {
  const Pose2 here{1.0, 2.0, 0.3};
  const Pose2 there{-31.0, 44.0, -1.1};
  MapRenderer straight = Renderer();
  Place(straight, 0, here);
  Place(straight, 1, there);
  MapRenderer around = Renderer();
  Place(around, 1, {200.0, 200.0, 2.0});
  Place(around, 0, there);
  EXPECT_FALSE(around.Render(nullptr, {}) == straight.Render(nullptr, {}));
  Place(around, 1, there);
  Place(around, 0, here);
  EXPECT_TRUE(around.Render(nullptr, {}) == straight.Render(nullptr, {}));
  EXPECT_EQ(around.bytes(), straight.bytes()) << "nothing stays where a submap was";
}

TEST_F(MapRendererTest, DrawsTheActiveSubmapWithoutKeepingIt) {
  MapRenderer renderer = Renderer();
  Place(renderer, 0, {});
  const grid::OccupancyGrid before = renderer.Render(nullptr, {});
  const grid::OccupancyGrid with_active = renderer.Render(&room_, {20.0, 0.0, 0.0});
  EXPECT_TRUE(Occupied(with_active, 23.01, 0.0));
  EXPECT_TRUE(Occupied(with_active, 3.01, 0.0));
  EXPECT_TRUE(renderer.Render(nullptr, {}) == before);
  MapRenderer placed = Renderer();
  Place(placed, 0, {});
  Place(placed, 1, {20.0, 0.0, 0.0});
  EXPECT_TRUE(placed.Render(nullptr, {}) == with_active);
}

// What was seen through a narrow door is far from everything else in the submap.
TEST_F(MapRendererTest, DrawsScatteredCells) {
  std::mt19937 random(7);
  for (int drawing = 0; drawing < 20; ++drawing) {
    grid::OccupancyGrid seen;
    seen.geometry = {.resolution = kResolution, .T_map_grid = {-2.0, 0.35, 0.0}, .width = 150, .height = 90};
    seen.cells.assign(seen.geometry.cell_count(), grid::kUnknownCell);
    for (int i = 0; i < 1 + drawing; ++i) seen.cells[random() % seen.cells.size()] = grid::CellFromProbability(0.9);
    const SubmapGrid submap = SubmapGrid::FromOccupancy(seen, {});
    const Pose2 pose{1.0, -2.0, 0.3 * drawing};
    MapRenderer renderer = Renderer();
    renderer.Place(0, pose, [&]() -> const SubmapGrid& { return submap; });
    const grid::OccupancyGrid grid = renderer.Render(nullptr, {});
    const Pose2 T_submap_map = Inverse(Pose2{1.0, -2.0, std::round(pose.yaw / 5e-4) * 5e-4});  // as it is drawn
    int known = 0;
    for (int row = -200; row < 200; ++row) {
      for (int column = -200; column < 200; ++column) {
        const Eigen::Vector2d p((column + 0.5) * kResolution, (row + 0.5) * kResolution);
        const bool expected = submap.log_odds().ValueAt(submap.log_odds().CellOf(T_submap_map * p)) > 0;
        EXPECT_EQ(Occupied(grid, p.x(), p.y()), expected) << "drawing " << drawing << ", " << p.transpose();
        known += expected ? 1 : 0;
      }
    }
    EXPECT_GT(known, 0);
  }
}

TEST_F(MapRendererTest, AsksForAGridOnlyWhereSomethingMoved) {
  MapRenderer renderer = Renderer();
  int asked = 0;
  const auto grid = [&]() -> const SubmapGrid& {
    ++asked;
    return room_;
  };
  EXPECT_TRUE(renderer.Place(0, {1.0, 1.0, 0.0}, grid));
  EXPECT_FALSE(renderer.Place(0, {1.0, 1.0, 0.0}, grid));
  EXPECT_FALSE(renderer.Place(0, {1.0, 1.0 + 1e-4, 0.0}, grid)) << "far less than a cell";
  EXPECT_EQ(asked, 1);
  EXPECT_TRUE(renderer.Place(0, {1.0, 1.1, 0.0}, grid));
  EXPECT_EQ(asked, 2);
}

TEST_F(MapRendererTest, DrawsAllAnewIfMostMove) {
  const auto place_all = [&](MapRenderer& renderer, const std::map<std::int64_t, Pose2>& poses) {
    int drawn = 0;
    renderer.Expect(poses);
    for (const auto& [id, pose] : poses)
      drawn += renderer.Place(id, pose, [this]() -> const SubmapGrid& { return room_; });
    return drawn;
  };
  MapRenderer renderer = Renderer();
  EXPECT_EQ(place_all(renderer, {{0, {}}, {1, {10.0, 0.0, 0.1}}, {2, {0.0, 10.0, 0.2}}}), 3);
  EXPECT_EQ(place_all(renderer, {{0, {}}, {1, {10.0, 0.0, 0.1}}, {2, {0.0, 10.5, 0.2}}}), 1);
  const std::map<std::int64_t, Pose2> last = {{0, {}}, {1, {10.0, 1.0, 0.1}}, {2, {0.0, 12.0, 0.2}}};
  EXPECT_EQ(place_all(renderer, last), 3);
  MapRenderer straight = Renderer();
  EXPECT_EQ(place_all(straight, last), 3);
  EXPECT_TRUE(renderer.Render(nullptr, {}) == straight.Render(nullptr, {}));
  EXPECT_EQ(renderer.bytes(), straight.bytes());
}

TEST_F(MapRendererTest, CostsWhatWasSeenNotWhatLiesBetween) {
  MapRenderer near = Renderer();
  Place(near, 0, {});
  Place(near, 1, {10.0, 0.0, 0.0});
  MapRenderer far = Renderer();
  Place(far, 0, {});
  Place(far, 1, {300.0, 300.0, 0.0});
  EXPECT_LE(far.bytes(), 3 * near.bytes());
  EXPECT_NEAR(far.Render(nullptr, {}).geometry.width * kResolution, 306.0, 0.15);
}

TEST_F(MapRendererTest, LeavesOutWhatIsAbsurdlyFarAway) {
  MapRenderer renderer = Renderer();
  Place(renderer, 0, {});
  const grid::OccupancyGrid before = renderer.Render(nullptr, {});
  Place(renderer, 1, {1e6, 1e6, 0.0});
  EXPECT_TRUE(renderer.Render(nullptr, {}) == before);
  EXPECT_TRUE(renderer.Render(&room_, {-1e6, 0.0, 0.0}) == before);
}

}  // namespace
}  // namespace enfilade::slam
