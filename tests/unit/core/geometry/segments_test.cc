// SPDX-License-Identifier: Apache-2.0
#include "core/geometry/segments.h"

#include <gtest/gtest.h>

namespace enfilade {
namespace {

using Eigen::Vector2d;

TEST(DistanceToSegmentTest, IsThatToTheNearestPoint) {
  EXPECT_DOUBLE_EQ(DistanceToSegment({1, 2}, {0, 0}, {3, 0}), 2);
  EXPECT_DOUBLE_EQ(DistanceToSegment({-3, 4}, {0, 0}, {3, 0}), 5);
  EXPECT_DOUBLE_EQ(DistanceToSegment({6, 4}, {0, 0}, {3, 0}), 5);
}

TEST(DistanceToSegmentTest, TakesASegmentWithoutLength) {
  EXPECT_DOUBLE_EQ(DistanceToSegment({3, 4}, {0, 0}, {0, 0}), 5);
}

TEST(SegmentDistanceTest, IsZeroWhereTheyCross) {
  EXPECT_DOUBLE_EQ(SegmentDistance({0, -1}, {0, 1}, {-1, 0}, {1, 0}), 0);
  EXPECT_DOUBLE_EQ(SegmentDistance({0, 0}, {0, 1}, {-1, 0}, {1, 0}), 0);  // they touch
}

TEST(SegmentDistanceTest, IsTheSameEitherWayRound) {
  const Vector2d a(0, 0), b(4, 0), c(5, 1), d(2, 3);
  const double distance = SegmentDistance(a, b, c, d);
  EXPECT_GT(distance, 0);
  EXPECT_DOUBLE_EQ(SegmentDistance(c, d, a, b), distance);
  EXPECT_DOUBLE_EQ(SegmentDistance(b, a, d, c), distance);
}

TEST(SegmentDistanceTest, IsThatOfAnEndToTheOtherSegment) {
  EXPECT_DOUBLE_EQ(SegmentDistance({0, 0}, {4, 0}, {2, 1}, {2, 5}), 1);
  EXPECT_DOUBLE_EQ(SegmentDistance({0, 0}, {4, 0}, {0, 2}, {4, 2}), 2);
}

}  // namespace
}  // namespace enfilade
