// SPDX-License-Identifier: Apache-2.0
#include "core/rooms/room_partition.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "core/grid/files/plan_image.h"
#include "io/file.h"
#include "tests/support/rooms/room_scores.h"
#include "tests/support/test_data.h"
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
  EXPECT_EQ(partition.doors[0].rooms, (std::array<int, 2>{1, 2}));
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

TEST(RoomPartition, ACorridorIsNotCutBetweenDoorsOppositeEachOther) {
  const DrawnRooms drawn({
      "##################################", "#          #          #          #", "#    a     #    b     #    c     #",
      "#          #          #          #", "#          #          #          #", "#          #          #          #",
      "####    #######    #######    ####", "#                                #", "#                                #",
      "# x                            y #", "#                                #", "#                                #",
      "#                                #", "####    #######    #######    ####", "#          #          #          #",
      "#          #          #          #", "#    d     #    e     #    f     #", "#          #          #          #",
      "##################################",
  });
  const RoomPartition partition = PartitionRooms(drawn.grid);
  EXPECT_EQ(partition.rooms.size(), 7U);
  EXPECT_EQ(partition.doors.size(), 6U);
  EXPECT_EQ(partition.RoomAt(drawn['x']), partition.RoomAt(drawn['y']));
}

TEST(RoomPartition, ADoorInTheRoomsCornerPartsToo) {
  const DrawnRooms drawn({
      "#####################",
      "#         #         #",
      "#         #         #",
      "#    a    #    b    #",
      "#         #         #",
      "#         #         #",
      "#         #         #",
      "#         #         #",
      "#                   #",
      "#                   #",
      "#                   #",
      "#                   #",
      "#####################",
  });
  const RoomPartition partition = PartitionRooms(drawn.grid);
  EXPECT_EQ(partition.rooms.size(), 2U);
  EXPECT_NE(partition.RoomAt(drawn['a']), partition.RoomAt(drawn['b']));
}

TEST(RoomPartition, AnOpenLeafHidesNoDoor) {
  const DrawnRooms drawn({
      "#####################",
      "#         #         #",
      "#         #         #",
      "#         #####     #",
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
  EXPECT_EQ(partition.rooms.size(), 2U);
  EXPECT_NE(partition.RoomAt(drawn['a']), partition.RoomAt(drawn['b']));
}

TEST(RoomPartition, FurnitureThatNarrowsTheWayPartsNothing) {
  const DrawnRooms drawn({
      "###########################",
      "#                         #",
      "#          #####          #",
      "#          #####          #",
      "#          #####          #",
      "#          #####          #",
      "#   a                b    #",
      "#                         #",
      "#                         #",
      "#          #####          #",
      "#          #####          #",
      "#          #####          #",
      "#          #####          #",
      "#                         #",
      "###########################",
  });
  const RoomPartition partition = PartitionRooms(drawn.grid);
  EXPECT_EQ(partition.rooms.size(), 1U);
  EXPECT_TRUE(partition.doors.empty());
}

TEST(RoomPartition, WhereNoRobotFitsBetweenTwoDoorsIsNoRoom) {
  const DrawnRooms drawn({
      "########################",
      "#         #  #         #",
      "#         ####         #",
      "#         #  #         #",
      "#         #  #         #",
      "#         #  #         #",
      "#    a            b    #",
      "#                      #",
      "#         #  #         #",
      "#         #  #         #",
      "#         #  #         #",
      "#         ####         #",
      "#         #  #         #",
      "########################",
  });
  const RoomPartition partition = PartitionRooms(drawn.grid);
  EXPECT_EQ(partition.rooms.size(), 2U);
  EXPECT_NE(partition.RoomAt(drawn['a']), partition.RoomAt(drawn['b']));
  // Without the rule the place between them is one.
  RoomOptions options;
  options.small_room = 0.0;
  EXPECT_EQ(PartitionRooms(drawn.grid, options).rooms.size(), 3U);
}

TEST(RoomPartition, ASmallRoomThatARobotHasEnteredIsARoom) {
  const DrawnRooms drawn({
      "###############",
      "#    #        #",
      "#    #        #",
      "#  b          #",
      "#             #",
      "#             #",
      "#    #        #",
      "######        #",
      "#             #",
      "#       a     #",
      "#             #",
      "#             #",
      "###############",
  });
  const std::vector<Eigen::Vector2d> places{drawn['a'], drawn['b']};
  const RoomPartition one = PartitionRooms(drawn.grid, {}, {.passages = {}, .trajectory = std::span(places).first(1)});
  EXPECT_EQ(one.RoomAt(drawn['a']), one.RoomAt(drawn['b']));
  const RoomPartition two = PartitionRooms(drawn.grid, {}, {.passages = {}, .trajectory = places});
  EXPECT_NE(two.RoomAt(drawn['a']), two.RoomAt(drawn['b']));
}

TEST(RoomPartition, AHalfSeenRoomIsARoomAndUnknownGroundCutsNothing) {
  const DrawnRooms drawn({
      "?????????????????????????",
      "??#####################??",
      "??#         #         ???",
      "??#         #        ????",
      "??#         #       ?????",
      "??#    a    #  b   ??????",
      "??#                 ?????",
      "??#                  ????",
      "??#                   ???",
      "??#                    ??",
      "??#         #         ???",
      "??#         #         ???",
      "??#         #          ??",
      "??##################  ???",
      "?????????????????????????",
  });
  const RoomPartition partition = PartitionRooms(drawn.grid);
  EXPECT_EQ(partition.rooms.size(), 2U);
  EXPECT_NE(partition.RoomAt(drawn['a']), partition.RoomAt(drawn['b']));
}

TEST(RoomPartition, AYardWithoutWallsIsOneRoom) {
  std::vector<std::string> rows(40, std::string(60, ' '));
  for (int box = 0; box < 5; ++box) {
    for (std::size_t i = 0; i < 3; ++i) rows[10 + i].replace(static_cast<std::size_t>(6 + 10 * box), 4, "####");
  }
  const RoomPartition partition = PartitionRooms(DrawnRooms(rows).grid);
  EXPECT_EQ(partition.rooms.size(), 1U);
}

// A wall without jambs that a laser can see, such as a curtain: only a robot's passage says that it is a door.
TEST(RoomPartition, AReportedPassageWithoutAnyWallIsNotBelieved) {
  const DrawnRooms drawn({
      "#####################",
      "#                   #",
      "#                   #",
      "#                   #",
      "#                   #",
      "#                   #",
      "#                   #",
      "#                   #",
      "#####################",
  });
  const std::vector<PassageHint> passages{{{2.6, 0.3}, {2.6, 1.9}}};
  EXPECT_EQ(PartitionRooms(drawn.grid, {}, {passages, {}}).rooms.size(), 1U);
}

TEST(RoomPartition, RoomsThatARobotWasInAreEntered) {
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
  const std::vector<Eigen::Vector2d> trajectory{
      drawn['a'], {1e9, 0.0}, {std::numeric_limits<double>::quiet_NaN(), 0.0}};
  const RoomPartition partition = PartitionRooms(drawn.grid, {}, {{}, trajectory});
  ASSERT_EQ(partition.rooms.size(), 2U);
  EXPECT_TRUE(partition.rooms[static_cast<std::size_t>(partition.RoomAt(drawn['a'])) - 1].entered);
  EXPECT_FALSE(partition.rooms[static_cast<std::size_t>(partition.RoomAt(drawn['b'])) - 1].entered);
}

TEST(RoomPartition, ItsAnswersAreInTheMapsFrame) {
  DrawnRooms drawn({
      "###########",
      "#         #",
      "#         #",
      "#    a    #",
      "#         #",
      "#         #",
      "###########",
  });
  drawn.grid.geometry.T_map_grid = {10.0, 20.0, M_PI / 2.0};
  const RoomPartition partition = PartitionRooms(drawn.grid);
  ASSERT_EQ(partition.rooms.size(), 1U);
  const Eigen::Vector2d a = drawn.grid.geometry.T_map_grid * drawn['a'];
  EXPECT_EQ(partition.RoomAt(a), 1);
  EXPECT_NEAR((partition.rooms[0].centre - a).norm(), 0.0, 1.1);
  EXPECT_NEAR(partition.rooms[0].area_m2, 9.0 * 5.0 / 16.0, 0.01);
  EXPECT_EQ(partition.RoomAt({0.0, 0.0}), 0);
}

TEST(RoomPartition, EmptyUnknownAndFullMapsHaveNoRooms) {
  grid::OccupancyGrid grid;
  EXPECT_TRUE(PartitionRooms(grid).rooms.empty());
  grid.geometry.width = 30;
  grid.geometry.height = 20;
  grid.cells.assign(grid.geometry.cell_count(), grid::kUnknownCell);
  EXPECT_TRUE(PartitionRooms(grid).rooms.empty());
  grid.cells.assign(grid.geometry.cell_count(), grid::CellFromProbability(1.0));
  EXPECT_TRUE(PartitionRooms(grid).rooms.empty());
}

// What lies behind a wall that is still unseen changes nothing on this side of it.
TEST(RoomPartition, ARoomStaysAsItIsWhenTheMapGrows) {
  const std::vector<std::string> whole{
      "###############################", "#         #         #         #", "#         #         #         #",
      "#         #         #         #", "#    a         b         c    #", "#                             #",
      "#                             #", "#                             #", "#         #         #         #",
      "#         #         #         #", "#         #         #         #", "###############################",
  };
  std::vector<std::string> part = whole;
  for (std::string& row : part) row.replace(22, 9, "?????????");
  const DrawnRooms before(part);
  const DrawnRooms after(whole);
  const RoomPartition small = PartitionRooms(before.grid);
  const RoomPartition large = PartitionRooms(after.grid);
  int changed = 0;
  for (std::size_t i = 0; i < small.labels.size(); ++i) {
    const bool in_a = small.labels[i] == small.RoomAt(after['a']);
    changed += in_a != (large.labels[i] == large.RoomAt(after['a'])) ? 1 : 0;
  }
  EXPECT_EQ(changed, 0);
}

// A free-standing wall leaves 1.25 m at one end and 2 m at the other. The robot has reported the two doors, and passed
// both ends of the wall without a report.
TEST(RoomPartition, AFreeStandingWallDividesNoHallThatARobotDroveIn) {
  const DrawnRooms drawn({
      "####################################################", "#                       #                          #",
      "#                       #                          #", "#                       #                          #",
      "#                       #                          #", "#         a             #             g            #",
      "#                       #                          #", "#                       #                          #",
      "#                       #                          #", "#                       #                          #",
      "######### b  #######################  h ############", "#                                                  #",
      "#                                                  #", "#                                                  #",
      "#                                                  #", "#   c                                         i    #",
      "#                                                  #", "#                                                  #",
      "#                                                  #", "#  d  #####################################    j   #",
      "#                                                  #", "#                                                  #",
      "#                                                  #", "#                                                  #",
      "#   e                                         k    #", "#                                                  #",
      "#                                                  #", "#                                                  #",
      "#                                                  #", "####################################################",
  });
  const std::vector<Eigen::Vector2d> way = drawn.Path("abcdekjihg");
  const Eigen::Vector2d half_door(0.5, 0.0);
  const std::vector<PassageHint> reported{{drawn['b'] - half_door, drawn['b'] + half_door},
                                          {drawn['h'] - half_door, drawn['h'] + half_door}};
  const RoomPartition partition = PartitionRooms(drawn.grid, {}, {.passages = reported, .trajectory = way});
  EXPECT_EQ(partition.rooms.size(), 3U);
  EXPECT_EQ(partition.RoomAt(drawn['c']), partition.RoomAt(drawn['e']));
  EXPECT_NE(partition.RoomAt(drawn['c']), partition.RoomAt(drawn['a']));
  EXPECT_NE(partition.RoomAt(drawn['c']), partition.RoomAt(drawn['g']));
}

// Ground truth of seven floor plans (MANIFEST.md of the recordings).
class PlanTest : public ::testing::TestWithParam<const char*> {};

TEST_P(PlanTest, MostRoomsAreFound) {
  ENFILADE_RECORDING_OR_SKIP(folder, "maps/ipa_rooms");
  testing::PlanScore sum;
  for (const std::string name : {"NLB", "lab_a_scan", "lab_c_scan", "lab_intel", "lab_ipa", "office_a", "office_b"}) {
    const auto plan = io::ReadFile(folder / (name + GetParam() + ".png"));
    const auto truth = io::ReadFile(folder / (name + "_gt_segmentation.png"));
    ASSERT_TRUE(plan.ok() && truth.ok()) << name;
    const auto plan_grid = grid::ReadPlan(*plan);
    const auto truth_grid = grid::ReadPlan(*truth);
    ASSERT_TRUE(plan_grid.ok() && truth_grid.ok()) << name;
    const testing::PlanScore score = testing::ScorePlan(PartitionRooms(*plan_grid), testing::RoomsOfTruth(*truth_grid));
    sum.rooms += score.rooms;
    sum.found += score.found;
    sum.segments += score.segments;
  }
  EXPECT_GE(sum.found, 0.85 * sum.rooms);
  EXPECT_LE(sum.extra(), 0.13 * sum.rooms);
}

INSTANTIATE_TEST_SUITE_P(Plans, PlanTest, ::testing::Values("", "_furnitures"),
                         [](const auto& param) { return *param.param == '\0' ? "Empty" : "Furnished"; });

}  // namespace
}  // namespace enfilade::rooms
