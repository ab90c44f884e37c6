// SPDX-License-Identifier: Apache-2.0
#include "core/slam/mapper/render_session.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/grid/overlay.h"
#include "core/slam/mapper/mapper.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/core/slam/synthetic_drive.h"

namespace enfilade::slam {
namespace {

using ::testing::HasSubstr;

struct Rendered {
  SlamMap map;
  grid::OccupancyGrid grid;
};

// A drive around a room with a pillar.
Rendered MapARoom() {
  const auto walls =
      testing::WallsFromText({"##########", "#........#", "#...##...#", "#........#", "##########"}, 2.0);
  const auto poses = testing::Drive({{3, 3}, {15, 3}, {15, 7}, {3, 7}, {3, 3}}, 0.4);
  Mapper mapper{SlamOptions()};
  for (const sensor::PairedScan& scan : testing::Record(walls, poses, {}, {}, 18)) mapper.AddScan(scan);
  mapper.Finish();
  Rendered rendered;
  rendered.map.Apply(mapper.TakeDelta());
  rendered.grid = mapper.RenderGrid();
  return rendered;
}

TEST(RenderSessionTest, InItsOwnFrameItIsTheMappersGrid) {
  const Rendered room = MapARoom();
  ASSERT_OK_AND_ASSIGN(const grid::OccupancyGrid grid, RenderSession(room.map, false, {}, {}));
  EXPECT_EQ(grid.geometry, room.grid.geometry);
  EXPECT_EQ(grid.cells, room.grid.cells);
}

TEST(RenderSessionTest, InAnotherFrameItIsTheSameRoom) {
  const Rendered room = MapARoom();
  const Pose2 T_to_map{3.0, -2.0, 0.5};
  ASSERT_OK_AND_ASSIGN(const grid::OccupancyGrid turned, RenderSession(room.map, false, T_to_map, {}));
  // Each wall of the room is near one of the turned grid.
  int walls = 0, found = 0;
  const grid::GridGeometry& from = room.grid.geometry;
  const grid::GridGeometry& to = turned.geometry;
  for (int row = 0; row < from.height; ++row) {
    for (int column = 0; column < from.width; ++column) {
      if (room.grid.cells[from.index(column, row)] < 200) continue;
      const Eigen::Vector2d place =
          T_to_map * (from.T_map_grid * (from.resolution * Eigen::Vector2d(column + 0.5, row + 0.5)));
      const Eigen::Vector2d at = (Inverse(to.T_map_grid) * place) / to.resolution;
      bool near = false;
      for (int y = -1; y <= 1; ++y) {
        for (int x = -1; x <= 1; ++x) {
          const int c = static_cast<int>(std::floor(at.x())) + x, r = static_cast<int>(std::floor(at.y())) + y;
          near = near || (to.contains(c, r) && turned.cells[to.index(c, r)] > 165);
        }
      }
      ++walls;
      found += near;
    }
  }
  ASSERT_GT(walls, 500);
  EXPECT_GT(static_cast<double>(found) / walls, 0.98);
}

TEST(RenderSessionTest, TheContinuedMapAndUnfinishedSubmapsAreLeftOut) {
  Rendered room = MapARoom();
  SlamMap first_only = room.map;
  std::erase_if(first_only.submaps, [](const auto& entry) { return entry.first != 0; });
  EXPECT_TRUE(RenderSession(first_only, true, {}, {})->cells.empty());
  first_only.submaps.at(0).finished = false;
  EXPECT_TRUE(RenderSession(first_only, false, {}, {})->cells.empty());
  EXPECT_TRUE(RenderSession({}, false, {}, {})->cells.empty());
  room.map.submaps.at(0).content = "damaged";
  EXPECT_STATUS(RenderSession(room.map, false, {}, {}), absl::StatusCode::kDataLoss, HasSubstr(""));
}

}  // namespace
}  // namespace enfilade::slam
