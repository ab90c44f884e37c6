// SPDX-License-Identifier: Apache-2.0
#include "core/doors/narrows.h"

#include <gmock/gmock.h>

#include <vector>

#include "tests/unit/core/doors/wall_map.h"

namespace enfilade::doors {
namespace {

using ::testing::HasSubstr;

// A wall along x = `x` with a gap of `width` whose middle is at y = 0, and side walls 2.5 m off.
std::vector<Segment> WallWithGap(double x, double width) {
  return {{{x, width / 2}, {x, 2.5}}, {{x, -width / 2}, {x, -2.5}}, {{-4, 2.5}, {6, 2.5}}, {{-4, -2.5}, {6, -2.5}}};
}

const std::vector<Eigen::Vector2d> kBefore = {{-1.5, 0.0}, {-1.2, 0.05}, {-1.0, 0.0}};

NarrowsSearch SearchEast(const std::vector<Segment>& walls, double begin = 0.3, double end = 2.2,
                         const GapOptions& options = {}) {
  std::vector<Eigen::Vector2d> places = kBefore;
  places.insert(places.end(), kWayEast.begin(), kWayEast.end());
  return FindNarrows(MapOf(walls, places), {.origin = {-1.5, 0.0}, .direction = {1.0, 0.0}, .begin = begin, .end = end},
                     options);
}

TEST(Narrows, AreFoundWithTheirWidthAndPlace) {
  for (const double width : {0.7, 0.9, 1.2, 1.6, 2.0}) {
    const NarrowsSearch search = SearchEast(WallWithGap(0.02, width));
    ASSERT_TRUE(search.narrows.has_value()) << width << ": " << search.reason;
    EXPECT_NEAR(search.narrows->width(), width, 0.11) << "two cells";
    EXPECT_NEAR(search.narrows->along, 1.52, 0.11);
    EXPECT_NEAR((search.narrows->middle() - Eigen::Vector2d(0.02, 0.0)).norm(), 0.0, 0.1);
    EXPECT_GT(search.narrows->left.y(), 0.0);
    EXPECT_LT(search.narrows->right.y(), 0.0);
    EXPECT_LT(search.narrows->depth, 0.5);
  }
}

TEST(Narrows, AreNeitherTooNarrowForARobotNorWiderThanADoor) {
  for (const double width : {0.3, 2.4, 3.5}) {
    EXPECT_FALSE(SearchEast(WallWithGap(0.02, width)).narrows.has_value()) << width;
  }
  GapOptions wide;
  wide.max_width = 2.6;
  EXPECT_TRUE(SearchEast(WallWithGap(0.02, 2.4), 0.3, 2.2, wide).narrows.has_value());
}

TEST(Narrows, AreFoundBetweenBeginAndEndOnly) {
  const std::vector<Segment> walls = WallWithGap(0.02, 0.9);
  EXPECT_TRUE(SearchEast(walls, 1.2, 1.8).narrows.has_value());
  EXPECT_FALSE(SearchEast(walls, 0.3, 1.2).narrows.has_value());
  EXPECT_FALSE(SearchEast(walls, 1.8, 2.2).narrows.has_value());
}

TEST(Narrows, LeftAndRightSwapIfTheWayIsReversed) {
  const LocalMap map = MapOf(WallWithGap(0.02, 0.9), kWayEast);
  const NarrowsSearch east =
      FindNarrows(map, {.origin = {-1.0, 0.0}, .direction = {1.0, 0.0}, .begin = 0.3, .end = 2.0}, {});
  const NarrowsSearch west =
      FindNarrows(map, {.origin = {1.0, 0.0}, .direction = {-1.0, 0.0}, .begin = 0.3, .end = 2.0}, {});
  ASSERT_TRUE(east.narrows.has_value()) << east.reason;
  ASSERT_TRUE(west.narrows.has_value()) << west.reason;
  EXPECT_EQ(east.narrows->left, west.narrows->right);
  EXPECT_EQ(east.narrows->right, west.narrows->left);
}

TEST(Narrows, MayBeCrossedObliquely) {
  const LocalMap map = MapOf(WallWithGap(0.02, 1.0), kWayEast);
  for (const double degrees : {-40.0, -20.0, 20.0, 40.0}) {
    const double angle = degrees * M_PI / 180.0;
    const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
    const NarrowsSearch search =
        FindNarrows(map, {.origin = -1.0 * direction, .direction = direction, .begin = 0.3, .end = 1.8}, {});
    ASSERT_TRUE(search.narrows.has_value()) << degrees << ": " << search.reason;
    EXPECT_NEAR(search.narrows->width(), 1.0, 0.15) << degrees;
  }
}

TEST(Narrows, ACorridorOfThisWidthIsNotOne) {
  const std::vector<Segment> corridor = {{{-4, 0.8}, {0, 0.8}},
                                         {{0.6, 0.8}, {4, 0.8}},
                                         {{0, 0.8}, {0, 2}},
                                         {{0.6, 0.8}, {0.6, 2}},
                                         {{-4, -0.8}, {4, -0.8}}};
  const NarrowsSearch search = SearchEast(corridor);
  EXPECT_FALSE(search.narrows.has_value()) << search.reason;
}

TEST(Narrows, APassageThroughAThickWallIsTooDeep) {
  const std::vector<Segment> thick = {{{-0.45, 0.45}, {0.45, 0.45}},   {{-0.45, -0.45}, {0.45, -0.45}},
                                      {{-0.45, 0.45}, {-0.45, 2.5}},   {{0.45, 0.45}, {0.45, 2.5}},
                                      {{-0.45, -0.45}, {-0.45, -2.5}}, {{0.45, -0.45}, {0.45, -2.5}}};
  const NarrowsSearch search = SearchEast(thick);
  EXPECT_FALSE(search.narrows.has_value());
  EXPECT_THAT(search.reason, HasSubstr("a passage, no door"));
  GapOptions deep;
  deep.max_depth = 1.2;
  deep.repeated = 9.0;
  const NarrowsSearch allowed = SearchEast(thick, 0.3, 2.2, deep);
  ASSERT_TRUE(allowed.narrows.has_value()) << allowed.reason;
  EXPECT_NEAR(allowed.narrows->depth, 0.9, 0.2);
}

TEST(Narrows, TheWayMustWidenOnBothSides) {
  // Wide before it, and as narrow as the gap behind it.
  const std::vector<Segment> funnel = {
      {{0, 0.45}, {0, 2.5}}, {{0, -0.45}, {0, -2.5}}, {{0, 0.45}, {4, 0.5}}, {{0, -0.45}, {4, -0.5}}};
  const NarrowsSearch search = SearchEast(funnel);
  EXPECT_FALSE(search.narrows.has_value());
  EXPECT_THAT(search.reason, HasSubstr("the way widens by"));
}

TEST(Narrows, AnEmptyMapHasNone) {
  const NarrowsSearch search =
      FindNarrows(LocalMap(0.05, 5.0), {.origin = {0, 0}, .direction = {1, 0}, .begin = 0.3, .end = 2.2}, GapOptions());
  EXPECT_FALSE(search.narrows.has_value());
  EXPECT_EQ(search.reason, "nothing narrow on the way");
}

}  // namespace
}  // namespace enfilade::doors
