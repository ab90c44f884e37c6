// SPDX-License-Identifier: Apache-2.0
#include "core/rooms/door_lines.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/rooms/door_odds.h"
#include "core/rooms/room_partition.h"
#include "tests/unit/core/rooms/drawn_rooms.h"

namespace enfilade::rooms {
namespace {

// An opening with a post in it: a door on its left, and a pane of glass on its right that a laser does not see.
const DrawnRooms& DoorBesideAPane() {
  static const DrawnRooms drawn({
      "##############################",
      "#                            #",
      "#                            #",
      "#                            #",
      "#         b                  #",
      "#                            #",
      "#                            #",
      "########1    2#     3#########",
      "#                            #",
      "#                            #",
      "#         a                  #",
      "#                            #",
      "#                            #",
      "##############################",
  });
  return drawn;
}

std::vector<DoorLine> LinesOf(const std::vector<PassageHint>& passages) {
  const DrawnRooms& drawn = DoorBesideAPane();
  std::vector<DoorLine> lines;
  AddPassages(ReadGround(drawn.grid, {}, {}), drawn.grid.geometry, passages, RoomOptions(), DoorOdds({}), lines);
  return lines;
}

PassageHint ReportOf(char a, char b, double slip) {
  return {DoorBesideAPane()[a], DoorBesideAPane()[b] + Eigen::Vector2d(0.0, slip)};
}

TEST(AddPassages, ALineGoesOnToTheNextWall) {
  const std::vector<DoorLine> lines = LinesOf({ReportOf('1', '2', 0.1)});
  ASSERT_EQ(lines.size(), 1U);
  const DrawnRooms& drawn = DoorBesideAPane();
  const double opening = (drawn['3'] - drawn['1']).norm();
  EXPECT_NEAR(lines[0].line.length() * drawn.grid.geometry.resolution, opening, 0.5);
  EXPECT_EQ(lines[0].evidence.reports, 1);
}

TEST(AddPassages, FurtherReportsCountForTheLongerLine) {
  const std::vector<DoorLine> lines =
      LinesOf({ReportOf('1', '2', 0.1), ReportOf('2', '1', -0.1), ReportOf('1', '2', 0.0)});
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_EQ(lines[0].evidence.reports, 3);
}

TEST(AddPassages, AWayBesideTheLineIsNoReportOfIt) {
  const Eigen::Vector2d a = DoorBesideAPane()['a'];
  const std::vector<DoorLine> lines =
      LinesOf({ReportOf('1', '2', 0.0), {a - Eigen::Vector2d(0.0, 0.6), a + Eigen::Vector2d(0.0, 0.6)}});
  ASSERT_GE(lines.size(), 1U);
  EXPECT_EQ(lines[0].evidence.reports, 1);
}

TEST(JoinWeight, IsThatOfAnOpenLineThatRobotsFitThrough) {
  const double radius = 0.4;  // m
  DoorLine line;
  line.evidence.a.seen = 1.0;
  line.evidence.b.seen = 1.0;
  line.evidence.width = 2.0;  // m
  line.openness = 2.0;
  EXPECT_DOUBLE_EQ(JoinWeight(line, radius), 2.0);
  line.evidence.width = 0.4;
  EXPECT_DOUBLE_EQ(JoinWeight(line, radius), 0.5);
  line.evidence.width = 0.05;
  EXPECT_DOUBLE_EQ(JoinWeight(line, radius), 0.02);
  line.openness = -2.0;  // a door, however narrow: it must part
  EXPECT_DOUBLE_EQ(JoinWeight(line, radius), -2.0);
}

TEST(JoinWeight, IsLessWhereTheJambsWereNotSeen) {
  DoorLine line;
  line.evidence.width = 2.0;
  line.openness = 9.0;
  line.evidence.a.seen = 1.0;
  line.evidence.b.seen = 0.5;
  EXPECT_DOUBLE_EQ(JoinWeight(line, 0.4), 3.0 * 0.25);
}

TEST(PartitionRooms, APaneBesideAReportedDoorPartsToo) {
  const std::vector<PassageHint> passages{ReportOf('1', '2', 0.1), ReportOf('2', '1', -0.1)};
  const DrawnRooms& drawn = DoorBesideAPane();
  const RoomPartition partition = PartitionRooms(drawn.grid, {}, {passages, {}});
  EXPECT_NE(partition.RoomAt(drawn['a']), partition.RoomAt(drawn['b']));
}

}  // namespace
}  // namespace enfilade::rooms
