// SPDX-License-Identifier: Apache-2.0
#include "server/app/closure/seen_grounds.h"

#include <gmock/gmock.h>

#include <memory>
#include <vector>

namespace enfilade::server {
namespace {

// One scan of a round room.
std::shared_ptr<const closure::SeenGround> MakeGround(float radius = 3.0F) {
  closure::PlacedScan placed;
  placed.scan.time = 1;
  placed.scan.angle_min = -3.14;
  placed.scan.angle_increment = 3.14 / 180.0;
  placed.scan.range_max = 30.0F;
  placed.scan.ranges.assign(360, radius);
  return std::make_shared<const closure::SeenGround>(std::vector<closure::PlacedScan>{placed});
}

TEST(SeenGrounds, GivesBackWhatIsKeptByItsDigest) {
  SeenGrounds grounds(100 << 20);
  EXPECT_EQ(grounds.Find("a"), nullptr);
  const auto a = MakeGround();
  const auto b = MakeGround();
  grounds.Keep("a", a);
  grounds.Keep("b", b);
  EXPECT_EQ(grounds.Find("a"), a);
  EXPECT_EQ(grounds.Find("b"), b);
  EXPECT_EQ(grounds.bytes(), a->bytes() + b->bytes());
}

TEST(SeenGrounds, ForgetsWhatWasAskedForLongestAgo) {
  const auto ground = MakeGround();
  SeenGrounds grounds(2 * ground->bytes());
  grounds.Keep("a", ground);
  grounds.Keep("b", ground);
  EXPECT_NE(grounds.Find("a"), nullptr);
  grounds.Keep("c", ground);
  EXPECT_EQ(grounds.Find("b"), nullptr);
  EXPECT_NE(grounds.Find("a"), nullptr);
  EXPECT_NE(grounds.Find("c"), nullptr);
  EXPECT_EQ(grounds.bytes(), 2 * ground->bytes());
}

TEST(SeenGrounds, OneStaysHoweverLarge) {
  const auto ground = MakeGround();
  SeenGrounds grounds(1);
  grounds.Keep("a", ground);
  EXPECT_EQ(grounds.Find("a"), ground);
  grounds.Keep("b", ground);
  EXPECT_EQ(grounds.Find("a"), nullptr);
  EXPECT_EQ(grounds.Find("b"), ground);
}

TEST(SeenGrounds, AGroundCountsTheMemoryOfItsGrids) {
  EXPECT_GT(MakeGround(3.0F)->bytes(), 100U << 10);
  EXPECT_GT(MakeGround(12.0F)->bytes(), 4 * MakeGround(3.0F)->bytes());
}

}  // namespace
}  // namespace enfilade::server
