// SPDX-License-Identifier: Apache-2.0
#include "core/rooms/room_partition.h"

#include <gtest/gtest.h>

#include "tests/unit/core/rooms/drawn_rooms.h"

namespace enfilade::rooms {
namespace {

TEST(RoomPartition, ADoorInAWallPartsTwoRooms) {
  const DrawnRooms drawn({
      "#####################",
      "#         #         #",
      "#         #         #",
      "#         #         #",
      "#    a         b    #",
      "#                   #",
      "#                   #",
      "#                   #",
      "#         #         #",
      "#         #         #",
      "#         #         #",
      "#####################",
  });
  const RoomPartition partition = PartitionRooms(drawn.grid);
  ASSERT_EQ(partition.rooms.size(), 2U);
  EXPECT_NE(partition.RoomAt(drawn['a']), partition.RoomAt(drawn['b']));
  ASSERT_EQ(partition.doors.size(), 1U);
  EXPECT_NEAR(partition.doors[0].width(), 1.0, 0.1);
}

TEST(RoomPartition, ABentCorridorIsOneRoom) {
  const DrawnRooms drawn({
      "####################",
      "#     a            #",
      "#                  #",
      "#                  #",
      "#                  #",
      "#                  #",
      "#                  #",
      "############       #",
      "           #       #",
      "           #       #",
      "           #       #",
      "           #       #",
      "           #  b    #",
      "           #       #",
      "           #########",
  });
  const RoomPartition partition = PartitionRooms(drawn.grid);
  EXPECT_EQ(partition.RoomAt(drawn['a']), partition.RoomAt(drawn['b']));
  EXPECT_TRUE(partition.doors.empty());
}

}  // namespace
}  // namespace enfilade::rooms
