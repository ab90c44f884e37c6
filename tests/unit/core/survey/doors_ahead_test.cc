// SPDX-License-Identifier: Apache-2.0
#include "core/survey/doors_ahead.h"

#include <gtest/gtest.h>

#include "tests/unit/core/survey/drawn_level.h"

namespace enfilade::survey {
namespace {

// Two boxes in a room, 1 m apart, before the wall to another room; the wall has a door, at x 8 to 9.
//   y 3.5      the wall
//   y 2 .. 3   boxes, x 2.5 .. 4 and x 5 .. 6.5
rooms::RoomPartition Furnished() {
  return DrawRooms(
      {
          "22222222222222222222",  // y 5.0
          "22222222222222222222",  // 4.5
          "22222222222222222222",  // 4.0
          "................11..",  // 3.5
          "11111111111111111111",  // 3.0
          "11111...11...1111111",  // 2.5
          "11111...11...1111111",  // 2.0
          "11111111111111111111",  // 1.5
          "11111111111111111111",  // 1.0
          "11111111111111111111",  // 0.5
          "11111111111111111111",  // 0.0
      },
      {{{8.0, 3.75}, {9.0, 3.75}, {1, 2}}});
}

// A robot saw a gap at (x, y), 2 m north of it.
Sighting SeenAt(double x, double y, double width) {
  return {{x, y - 2.0, M_PI / 2.0}, SeenGap{{2.0, 0.0, 0.0}, width}};
}

bool MayBeUnknown(const rooms::RoomPartition& rooms, const Sighting& sighting, const std::vector<Pose2>& passed = {}) {
  return DoorsAhead(rooms, {}, passed).MayBeUnknown(sighting);
}

TEST(DoorsAhead, AGapBetweenFurnitureIsNoDoor) {
  EXPECT_FALSE(MayBeUnknown(Furnished(), SeenAt(4.5, 2.5, 1.0)));
  // Without its place the gap cannot be told from a closed door in the wall behind it.
  Sighting somewhere = SeenAt(4.5, 2.5, 1.0);
  somewhere.gap.reset();
  EXPECT_TRUE(MayBeUnknown(Furnished(), somewhere));
}

TEST(DoorsAhead, AGapToAnotherRoomMayBeADoor) {
  EXPECT_TRUE(MayBeUnknown(Furnished(), SeenAt(8.5, 3.75, 1.0)));
  const std::vector<Pose2> passed = {{8.5, 3.75, M_PI / 2.0}};
  EXPECT_FALSE(MayBeUnknown(Furnished(), SeenAt(8.5, 3.75, 1.0), passed)) << "robots have gone through";
}

// A room of 10 x 3 m, and what lies north of it: rows of 0.5 m, the first is the top.
rooms::RoomPartition RoomBefore(std::vector<std::string> rows) {
  rows.insert(rows.end(), 6, std::string(20, '1'));
  return DrawRooms(rows, {});
}

// What robots have seen of a room through its door is, as long as it is little, ground of the room before it.
TEST(DoorsAhead, AGapWithoutAWayRoundMayBeADoor) {
  const rooms::RoomPartition rooms = RoomBefore({
      "........111.........", "........111.........", ".........1..........",
      ".........1..........",  // y 3.0: the wall, with a gap at x 4.5 to 5
  });
  EXPECT_TRUE(MayBeUnknown(rooms, SeenAt(4.75, 3.25, 0.5)));
}

TEST(DoorsAhead, ANookIsNoRoom) {
  const rooms::RoomPartition rooms = RoomBefore({
      ".........1..........",
      ".........1..........",  // y 3.0: a recess of 0.5 m^2, its opening at x 4.5 to 5
  });
  EXPECT_FALSE(MayBeUnknown(rooms, SeenAt(4.75, 3.25, 0.5)));
}

// Of so much ground it is known that no door parts it from the room.
TEST(DoorsAhead, ABayIsOfItsRoom) {
  const rooms::RoomPartition rooms = RoomBefore({
      ".......11111........", ".......11111........",
      ".......11111........",  // a bay of 3.75 m^2
      ".........1..........",  // y 3.0: the wall, with a gap at x 4.5 to 5
  });
  EXPECT_FALSE(MayBeUnknown(rooms, SeenAt(4.75, 3.25, 0.5)));
}

// A nook at the side of a box, and the next room behind the wall.
TEST(DoorsAhead, ANookBeforeAWallIsNoDoor) {
  const std::vector<std::string> rows = {"2222222", "2222222", ".......", "111...1", "111...1", "1111111", "1111111"};
  EXPECT_FALSE(MayBeUnknown(DrawRooms(rows, {}), SeenAt(3.25, 1.75, 0.5)));
  EXPECT_TRUE(MayBeUnknown(DrawRooms(rows, {{{3.0, 2.25}, {3.5, 2.25}, {1, 2}}}), SeenAt(3.25, 1.75, 0.5)))
      << "there is a door in the wall";
}

TEST(DoorsAhead, AGapWithNothingKnownBehindItMayBeADoor) {
  EXPECT_TRUE(MayBeUnknown(DrawRooms({"....", "1111", "1111", "1111"}, {}), SeenAt(1.0, 1.75, 1.0)));
}

// Of two doors beside each other one is known.
TEST(DoorsAhead, ADoorBesideOneThatRobotsWentThroughMayBeUnknown) {
  const rooms::RoomPartition rooms =
      DrawRooms({"222.333", "222.333", "222.333", ".......", "1111111", "1111111"},
                {{{0.6, 1.25}, {1.4, 1.25}, {1, 2}}, {{1.9, 1.25}, {2.7, 1.25}, {1, 3}}});
  const std::vector<Pose2> passed = {{1.0, 1.25, M_PI / 2.0}};
  EXPECT_FALSE(MayBeUnknown(rooms, SeenAt(1.2, 1.25, 0.8), passed));
  EXPECT_TRUE(MayBeUnknown(rooms, SeenAt(1.9, 1.25, 0.8), passed));
}

}  // namespace
}  // namespace enfilade::survey
