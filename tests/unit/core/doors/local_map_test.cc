// SPDX-License-Identifier: Apache-2.0
#include "core/doors/local_map.h"

#include <gtest/gtest.h>

namespace enfilade::doors {
namespace {

// A full turn that sees a circle of `range` m.
sensor::LaserScan Circle(float range) {
  sensor::LaserScan scan;
  scan.angle_min = -M_PI;
  scan.angle_increment = M_PI / 360.0;
  scan.range_max = 30.0F;
  scan.ranges.assign(720, range);
  return scan;
}

TEST(LocalMap, HoldsHitsAndFreeGround) {
  LocalMap map(0.05, 5.0);
  map.Add(Circle(2.0F), {10.0, -20.0, 0.3});
  EXPECT_TRUE(map.IsFree(map.CellOf(11.0), map.CellOf(-20.0)));
  EXPECT_FALSE(map.IsFree(map.CellOf(13.0), map.CellOf(-20.0)));
  EXPECT_FALSE(map.IsOccupied(map.CellOf(13.0), map.CellOf(-20.0)));
  const auto surface = map.SurfaceWithin({10.0, -20.0}, 3.0);
  EXPECT_GT(surface.size(), 200U);
  for (const Eigen::Vector2d& p : surface) EXPECT_NEAR((p - Eigen::Vector2d(10.0, -20.0)).norm(), 2.0, 0.06);
}

TEST(LocalMap, ForgetsAPersonWhoWalksOn) {
  LocalMap map(0.05, 5.0);
  sensor::LaserScan with_person = Circle(3.0F);
  for (std::size_t i = 350; i < 370; ++i) with_person.ranges[i] = 1.5F;
  map.Add(with_person, {});
  EXPECT_TRUE(map.IsOccupied(map.CellOf(1.51), map.CellOf(0.0)));
  for (int i = 0; i < 4; ++i) map.Add(Circle(3.0F), {});
  EXPECT_FALSE(map.IsOccupied(map.CellOf(1.51), map.CellOf(0.0)));
}

TEST(LocalMap, MovesWithTheRobot) {
  LocalMap map(0.05, 5.0);
  for (double x = 0.0; x < 30.0; x += 0.5) map.Add(Circle(2.0F), {x, 0.0, 0.0});
  EXPECT_TRUE(map.IsFree(map.CellOf(29.0), map.CellOf(0.0)));
  EXPECT_FALSE(map.IsFree(map.CellOf(0.0), map.CellOf(0.0))) << "out of reach, forgotten";
}

TEST(LocalMap, JoinsByFreeGroundOnly) {
  LocalMap map(0.05, 5.0);
  map.Add(Circle(4.0F), {});
  const Eigen::Vector2d from(-1.0, 0.0);
  const Eigen::Vector2d to(1.0, 0.0);
  // A short line in the open can be gone round, one across all of the disc cannot.
  EXPECT_TRUE(map.AreJoined(from, to, {{0.0, -0.5}, {0.0, 0.5}}, {{0.0, 0.0}, 2.0}));
  EXPECT_FALSE(map.AreJoined(from, to, {{0.0, -3.0}, {0.0, 3.0}}, {{0.0, 0.0}, 2.0}));
}

TEST(LocalMap, RestoresItsStateBitForBit) {
  LocalMap map(0.05, 5.0);
  map.Add(Circle(2.0F), {1.0, 2.0, 0.3});
  std::string bytes;
  BinaryWriter writer(bytes);
  map.Write(writer);
  LocalMap again(0.05, 5.0);
  BinaryReader reader(bytes);
  ASSERT_TRUE(again.Read(reader));
  EXPECT_TRUE(reader.at_end());
  std::string second;
  BinaryWriter second_writer(second);
  again.Write(second_writer);
  EXPECT_EQ(bytes, second);
  LocalMap other(0.10, 5.0);
  BinaryReader other_reader(bytes);
  EXPECT_FALSE(other.Read(other_reader)) << "of another size";
}

}  // namespace
}  // namespace enfilade::doors
