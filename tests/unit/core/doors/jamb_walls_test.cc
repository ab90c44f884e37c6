// SPDX-License-Identifier: Apache-2.0
#include "core/doors/jamb_walls.h"

#include <gtest/gtest.h>

#include "tests/unit/core/doors/wall_map.h"

namespace enfilade::doors {
namespace {

TEST(JambWalls, AreTheWallThatTheDoorIsAGapIn) {
  const LocalMap map = MapOf({{{0.01, 0.5}, {0.01, 2.0}}, {{0.01, -0.5}, {0.01, -3.0}}}, kWayEast);
  const JambWalls walls = FindJambWalls(map, {0.0, 0.5}, {0.0, -0.5}, 2.0);
  EXPECT_NEAR(walls.left, 1.5, 0.1);
  EXPECT_NEAR(walls.right, 2.0, 0.1) << "the limit";
  EXPECT_EQ(walls.left_again, 0.0);
  EXPECT_NEAR((walls.left_end - Eigen::Vector2d(0.0, 2.0)).norm(), 0.0, 0.15);
  EXPECT_LT(ParallelSurfaces(map, {0.0, 0.5}, {0.0, -0.5}, 1.0), 0.3);
}

TEST(JambWalls, ContinueBehindAPaneOfGlass) {
  const LocalMap map =
      MapOf({{{0.01, 0.5}, {0.01, 0.65}}, {{0.01, 1.65}, {0.01, 2.5}}, {{0.01, -0.5}, {0.01, -3.0}}}, kWayEast);
  const JambWalls walls = FindJambWalls(map, {0.0, 0.5}, {0.0, -0.5}, 2.2);
  EXPECT_NEAR(walls.left, 0.15, 0.1);
  EXPECT_NEAR(walls.left_again, 0.85, 0.15);
  EXPECT_GT(walls.left_end.y(), 2.3) << "the pane is closed with the wall";
  const Eigen::Vector2d before(-0.5, 0.0);
  const Eigen::Vector2d behind(0.5, 0.0);
  EXPECT_TRUE(map.AreJoined(before, behind, {{0.0, 0.5}, {0.0, -0.5}}, {{0.0, 0.0}, 2.0})) << "through the pane";
  EXPECT_FALSE(map.AreJoined(before, behind, {walls.left_end, walls.right_end}, {{0.0, 0.0}, 2.0}));
}

TEST(JambWalls, MayHaveLongerGapsIfTheCallerAllowsThem) {
  const LocalMap map =
      MapOf({{{0.01, 0.5}, {0.01, 0.7}}, {{0.01, 1.1}, {0.01, 2.0}}, {{0.01, -0.5}, {0.01, -2.0}}}, kWayEast);
  EXPECT_NEAR(FindJambWalls(map, {0.0, 0.5}, {0.0, -0.5}, 2.0).left, 0.2, 0.1);
  EXPECT_NEAR(FindJambWalls(map, {0.0, 0.5}, {0.0, -0.5}, 2.0, 0.5).left, 1.5, 0.1);
}

TEST(JambWalls, MayBeTurnedAgainstThePostsOfAThickWall) {
  // The posts were found on the two faces of a wall of 0.3 m.
  const LocalMap map = MapOf({{{-0.15, 0.4}, {-0.15, 2.0}},
                              {{0.15, 0.4}, {0.15, 2.0}},
                              {{-0.15, 0.4}, {0.15, 0.4}},
                              {{-0.15, -0.4}, {-0.15, -2.0}},
                              {{0.15, -0.4}, {0.15, -2.0}},
                              {{-0.15, -0.4}, {0.15, -0.4}}},
                             kWayEast);
  const JambWalls walls = FindJambWalls(map, {-0.15, 0.4}, {0.15, -0.4}, 1.5);
  EXPECT_GT(walls.length(), 2.8);
}

TEST(JambWalls, OfFurnitureAreShort) {
  const LocalMap map = MapOf({{{0.0, 0.5}, {0.0, 0.9}}, {{0.0, -0.5}, {0.0, -0.9}}}, kWayEast);
  EXPECT_LT(FindJambWalls(map, {0.0, 0.5}, {0.0, -0.5}, 2.0).length(), 1.0);
}

TEST(ParallelSurfaces, AreACorridorsWallsBetweenStaggeredOpenings) {
  // Left the wall ends where the robot comes from, right it begins behind: narrow between the two ends.
  const LocalMap map = MapOf({{{-3.0, 0.85}, {-0.3, 0.85}}, {{0.3, -0.85}, {3.0, -0.85}}}, kWayEast);
  const Eigen::Vector2d left(-0.3, 0.85);
  const Eigen::Vector2d right(0.3, -0.85);
  EXPECT_GT(ParallelSurfaces(map, left, right, 1.0), 0.9);
  EXPECT_LT(FindJambWalls(map, left, right, 2.0).length(), 0.5);
}

TEST(ParallelSurfaces, ALeafOrACornerOnOneSideIsNone) {
  const LocalMap map =
      MapOf({{{0.0, 0.5}, {0.0, 2.0}}, {{0.0, 0.5}, {1.0, 0.6}}, {{0.0, -0.5}, {0.0, -2.0}}}, kWayEast);
  EXPECT_LT(ParallelSurfaces(map, {0.0, 0.5}, {0.0, -0.5}, 1.0), 0.3);
}

}  // namespace
}  // namespace enfilade::doors
