// SPDX-License-Identifier: Apache-2.0
#include "core/doors/jamb_walls.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace enfilade::doors {
namespace {

struct Segment {
  Eigen::Vector2d a;
  Eigen::Vector2d b;
};

// What scans from these places see of walls without thickness.
LocalMap MapOf(const std::vector<Segment>& walls, const std::vector<Eigen::Vector2d>& places) {
  LocalMap map(0.05, 5.0);
  for (const Eigen::Vector2d& from : places) {
    sensor::LaserScan scan;
    scan.angle_min = -M_PI;
    scan.angle_increment = M_PI / 720.0;
    scan.range_max = 30.0F;
    for (int i = 0; i < 1440; ++i) {
      const double angle = scan.angle(static_cast<std::size_t>(i));
      const Eigen::Vector2d ray(std::cos(angle), std::sin(angle));
      double nearest = INFINITY;
      for (const Segment& wall : walls) {
        const Eigen::Vector2d edge = wall.b - wall.a;
        const Eigen::Vector2d to = wall.a - from;
        const double cross = ray.x() * edge.y() - ray.y() * edge.x();
        if (std::abs(cross) < 1e-12) continue;
        const double range = (to.x() * edge.y() - to.y() * edge.x()) / cross;
        const double along = (to.x() * ray.y() - to.y() * ray.x()) / cross;
        if (range > 0.0 && along >= 0.0 && along <= 1.0) nearest = std::min(nearest, range);
      }
      scan.ranges.push_back(static_cast<float>(nearest));
    }
    map.Add(scan, {from.x(), from.y(), 0.0});
  }
  return map;
}

const std::vector<Eigen::Vector2d> kWayEast = {{-1.5, 0.02}, {-1.0, 0.01}, {-0.5, 0.0}, {0.5, 0.0}, {1.0, 0.01}};

TEST(JambWalls, AreTheWallThatTheDoorIsAGapIn) {
  const LocalMap map = MapOf({{{0.01, 0.5}, {0.01, 2.0}}, {{0.01, -0.5}, {0.01, -3.0}}}, kWayEast);
  const JambWalls walls = FindJambWalls(map, {0.0, 0.5}, {0.0, -0.5}, 2.0);
  EXPECT_NEAR(walls.left, 1.5, 0.1);
  EXPECT_NEAR(walls.right, 2.0, 0.1) << "the limit";
  EXPECT_EQ(walls.left_again, 0.0);
  EXPECT_NEAR((walls.left_end - Eigen::Vector2d(0.0, 2.0)).norm(), 0.0, 0.15);
  EXPECT_LT(ParallelSurfaces(map, {0.0, 0.5}, {0.0, -0.5}, 1.0), 0.3);
}

TEST(JambWalls, GoOnBehindAPaneOfGlass) {
  const LocalMap map =
      MapOf({{{0.01, 0.5}, {0.01, 0.65}}, {{0.01, 1.65}, {0.01, 2.5}}, {{0.01, -0.5}, {0.01, -3.0}}}, kWayEast);
  const JambWalls walls = FindJambWalls(map, {0.0, 0.5}, {0.0, -0.5}, 2.2);
  EXPECT_NEAR(walls.left, 0.15, 0.1);
  EXPECT_NEAR(walls.left_again, 0.85, 0.15);
  EXPECT_GT(walls.left_end.y(), 2.3) << "the pane is closed with the wall";
  const Eigen::Vector2d before(-0.5, 0.0);
  const Eigen::Vector2d behind(0.5, 0.0);
  EXPECT_TRUE(map.Joined(before, behind, {0.0, 0.5}, {0.0, -0.5}, {0.0, 0.0}, 2.0)) << "through the pane";
  EXPECT_FALSE(map.Joined(before, behind, walls.left_end, walls.right_end, {0.0, 0.0}, 2.0));
}

TEST(JambWalls, MayMissMoreWhereTheCallerSaysSo) {
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

TEST(JambWalls, OfThingsThatStandAboutAreShort) {
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
