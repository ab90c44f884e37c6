// SPDX-License-Identifier: Apache-2.0
#include "core/geometry/convex_hull.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace enfilade {
namespace {

using Eigen::Vector2d;
using ::testing::ElementsAre;
using ::testing::SizeIs;

TEST(ConvexHullTest, HasTheOuterPointsOnly) {
  const ConvexHull hull({{0, 0}, {2, 1}, {4, 0}, {2, 0}, {4, 3}, {0, 3}, {0, 0}, {1, 2}});
  EXPECT_THAT(hull.outline(), ElementsAre(Vector2d(0, 0), Vector2d(4, 0), Vector2d(4, 3), Vector2d(0, 3)));
  EXPECT_DOUBLE_EQ(hull.Area(), 12);
}

TEST(ConvexHullTest, ContainsWhatIsNearlyInside) {
  const ConvexHull hull({{0, 0}, {4, 0}, {0, 4}});
  EXPECT_TRUE(hull.Contains({1, 1}, 0));
  EXPECT_FALSE(hull.Contains({3, 3}, 0.5));
  EXPECT_FALSE(hull.Contains({1, -0.3}, 0.2));
  EXPECT_TRUE(hull.Contains({1, -0.3}, 0.4));
}

TEST(ConvexHullTest, PointsOnOneLineHaveNone) {
  const ConvexHull hull({{0, 0}, {1, 1}, {3, 3}, {2, 2}});
  EXPECT_THAT(hull.outline(), SizeIs(testing::Lt(3U)));
  EXPECT_EQ(hull.Area(), 0);
  EXPECT_FALSE(hull.Contains({1, 1}, 1));
  EXPECT_THAT(ConvexHull({}).outline(), SizeIs(0));
  EXPECT_THAT(ConvexHull({{5, 5}}).outline(), SizeIs(1));
}

}  // namespace
}  // namespace enfilade
