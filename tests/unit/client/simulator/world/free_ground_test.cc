// SPDX-License-Identifier: Apache-2.0
#include "client/simulator/world/free_ground.h"

#include <gtest/gtest.h>

#include "client/simulator/campus/campus_yaml.h"
#include "tests/support/status_assertions.h"

namespace enfilade::simulator {
namespace {

// Two rooms, 4 m x 4 m, with a door between them, and a cupboard in the second one.
class FreeGroundTest : public ::testing::Test {
 protected:
  static Campus TwoRooms(const std::string& door) {
    auto campus = ParseCampus(
        "areas:\n"
        "  - id: west\n    rect: [0, 0, 4, 4]\n    doors: [" +
        door +
        "]\n"
        "  - {id: east, rect: [4, 0, 4, 4]}\n"
        "boxes:\n  - {rect: [5.5, 1.2, 0.6, 2.79], height: 1.5}\n");
    EXPECT_OK(campus);
    return *campus;
  }
  // The shortest distance of the way from a point.
  static double DistanceTo(const Eigen::Vector2d& point, Eigen::Vector2d from,
                           const std::vector<Eigen::Vector2d>& way) {
    double nearest = 1e9;
    for (const Eigen::Vector2d& to : way) {
      for (double t = 0.0; t <= 1.0; t += 0.01) nearest = std::min(nearest, (from + t * (to - from) - point).norm());
      from = to;
    }
    return nearest;
  }
};

TEST_F(FreeGroundTest, AWayGoesThroughTheDoorAndAroundTheCupboard) {
  const World world(TwoRooms("{id: d, side: east, at: 3, width: 0.8}"));
  const FreeGround ground(world.level("ground"));
  const Eigen::Vector2d from(1.0, 1.0);
  const Eigen::Vector2d to(7.0, 3.0);
  const std::vector<Eigen::Vector2d> way = ground.Way(from, to);
  ASSERT_FALSE(way.empty());
  EXPECT_EQ(way.back(), to);
  EXPECT_LT(DistanceTo({4.0, 3.0}, from, way), 0.15) << "the middle of the door";
  EXPECT_LT(DistanceTo({5.8, 0.6}, from, way), 0.3) << "below the cupboard";
  EXPECT_LE(way.size(), 8U) << "corners only";
  Eigen::Vector2d last = from;
  for (const Eigen::Vector2d& corner : way) {
    EXPECT_TRUE(ground.IsFree(last, corner));
    last = corner;
  }
}

TEST_F(FreeGroundTest, ThereIsNoWayThroughAClosedDoorOrOutOfTheBox) {
  const World closed(TwoRooms("{id: d, side: east, at: 3, width: 0.8, state: closed}"));
  EXPECT_TRUE(FreeGround(closed.level("ground")).Way({1.0, 1.0}, {7.0, 3.0}).empty());
  const World open(TwoRooms("{id: d, side: east, at: 3, width: 0.8}"));
  const FreeGround ground(open.level("ground"));
  EXPECT_TRUE(ground.Way({1.0, 1.0}, {7.0, 3.0}, FreeGround::Box{{0.0, 0.0}, {4.5, 4.0}}).empty());
  EXPECT_FALSE(ground.Way({1.0, 1.0}, {3.0, 3.0}, FreeGround::Box{{0.0, 0.0}, {4.0, 4.0}}).empty());
  EXPECT_TRUE(ground.Way({1.0, 1.0}, {5.8, 2.5}).empty()) << "inside the cupboard";
}

TEST_F(FreeGroundTest, TheRobotNeedsItsClearance) {
  const World world(TwoRooms("{id: d, side: east, at: 3, width: 0.8}"));
  EXPECT_FALSE(FreeGround(world.level("ground"), 0.3).Way({1.0, 1.0}, {5.0, 3.0}).empty());
  EXPECT_TRUE(FreeGround(world.level("ground"), 0.45).Way({1.0, 1.0}, {5.0, 3.0}).empty());
  const FreeGround ground(world.level("ground"));
  EXPECT_FALSE(ground.IsFree(Eigen::Vector2d(0.2, 2.0)));
  EXPECT_TRUE(ground.IsFree(Eigen::Vector2d(0.6, 2.0)));
}

}  // namespace
}  // namespace enfilade::simulator
