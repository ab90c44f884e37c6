// SPDX-License-Identifier: Apache-2.0
#include "core/rooms/path_narrows.h"

#include <algorithm>
#include <vector>

#include "core/rooms/room_partition.h"
#include "gtest/gtest.h"
#include "tests/unit/core/rooms/drawn_rooms.h"

namespace enfilade::rooms {
namespace {

std::vector<DoorCandidate> NarrowsOn(const DrawnRooms& drawn, const std::vector<Eigen::Vector2d>& path) {
  const GroundMap ground = ReadGround(drawn.grid, {}, path);
  return FindNarrowsOnPath(ground, drawn.grid.geometry, path, 2.0);
}

DrawnRooms DoorBeforeABox() {
  // The box stands so near behind the door that the ground is no wider between them than in the door.
  return DrawnRooms({
      "######################",
      "#                    #",
      "#                    #",
      "#    a               #",
      "#                    #",
      "#                    #",
      "#                    #",
      "#                    #",
      "########      ########",
      "#         b          #",
      "#                    #",
      "#        ####        #",
      "#        ####        #",
      "#        ####        #",
      "#   c    ####        #",
      "#        ####        #",
      "#        ####        #",
      "######################",
  });
}

TEST(PathNarrows, AStraightCorridorHasNone) {
  const DrawnRooms drawn({
      "##############################",
      "#                            #",
      "#                            #",
      "#  a                      b  #",
      "#                            #",
      "#                            #",
      "##############################",
  });
  EXPECT_TRUE(NarrowsOn(drawn, drawn.Path("ab")).empty());
}

TEST(PathNarrows, ADoorIsFoundHoweverObliquelyItIsPassed) {
  const DrawnRooms drawn = DoorBeforeABox();
  const std::vector<DoorCandidate> narrows = NarrowsOn(drawn, drawn.Path("abc"));
  // The wall's row is 9 squares of 5 cells up, its gap from column 8 to 13.
  const auto is_the_door = [](const DoorCandidate& line) {
    return std::abs(line.a.y() - line.b.y()) <= 1.0 && line.middle().y() > 44.0 && line.middle().y() < 50.0 &&
           std::abs(line.middle().x() - 54.5) < 2.0 && std::abs(line.length() - 31.0) <= 1.0;
  };
  EXPECT_EQ(std::count_if(narrows.begin(), narrows.end(), is_the_door), 1) << narrows.size();
}

TEST(PathNarrows, AJumpIsNoWay) {
  const DrawnRooms drawn = DoorBeforeABox();
  EXPECT_TRUE(NarrowsOn(drawn, {drawn['a'], drawn['c']}).empty());
  EXPECT_TRUE(NarrowsOn(drawn, {}).empty());
}

TEST(PathNarrows, TheirDoorsPartRooms) {
  const DrawnRooms drawn = DoorBeforeABox();
  const RoomPartition partition = PartitionRooms(drawn.grid, {}, {{}, drawn.Path("abc")});
  EXPECT_NE(partition.RoomAt(drawn['a']), partition.RoomAt(drawn['c']));
}

}  // namespace
}  // namespace enfilade::rooms
