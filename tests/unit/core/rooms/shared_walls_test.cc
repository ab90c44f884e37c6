// SPDX-License-Identifier: Apache-2.0
#include "core/rooms/shared_walls.h"

#include <gtest/gtest.h>

#include "tests/unit/core/rooms/drawn_rooms.h"

namespace enfilade::rooms {
namespace {

// The wall between `a` and `b` is cut off at the right, where the way is open; the one below is 1 m thick.
TEST(SharedWalls, AreAsLongAsTheWallBetweenTwoRegions) {
  const DrawnRooms drawn({
      "##########",
      "#        #",
      "#   a    #",
      "#        #",
      "######   #",
      "#        #",
      "#   b    #",
      "#        #",
      "##########",
      "##########",
      "##########",
      "##########",
      "#        #",
      "#   c    #",
      "#        #",
      "##########",
  });
  const GroundMap ground = ReadGround(drawn.grid, {}, {});
  const auto at = [&](double x, double y) { return ToCells(drawn.grid.geometry, {x, y}); };
  const DoorCandidate line{at(1.475, 2.875), at(2.275, 2.875)};
  const CutGround cut = CutAlong(ground, DistancesToWalls(ground), std::vector<DoorCandidate>{line});
  const auto region = [&](char letter) {
    const Eigen::Vector2d p = drawn[letter] / drawn.grid.geometry.resolution;
    return cut.map.region[ground.index(static_cast<int>(p.x()), static_cast<int>(p.y()))];
  };
  const SharedWalls walls(ground, cut.map);
  ASSERT_NE(region('a'), region('b'));
  EXPECT_NEAR(walls.Between(region('a'), region('b')), 1.25, 0.06);
  EXPECT_EQ(walls.Between(region('b'), region('a')), walls.Between(region('a'), region('b')));
  EXPECT_EQ(walls.Between(region('b'), region('c')), 0.0);
  const std::vector<std::int32_t> upper{region('a')};
  const std::vector<std::int32_t> others{region('b'), region('c')};
  EXPECT_EQ(walls.Between(upper, others), walls.Between(region('a'), region('b')));
}

}  // namespace
}  // namespace enfilade::rooms
