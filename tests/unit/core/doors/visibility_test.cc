// SPDX-License-Identifier: Apache-2.0
#include "core/doors/visibility.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "tests/support/pose_matchers.h"
#include "tests/unit/core/doors/wall_map.h"

namespace enfilade::doors {
namespace {

constexpr float kInfinite = std::numeric_limits<float>::infinity();
constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

// `beams` of a quarter degree each, all with `range`.
sensor::LaserScan FineScan(std::size_t beams, float range) {
  sensor::LaserScan scan;
  scan.angle_min = 0.0;
  scan.angle_increment = kDegree / 4.0;
  scan.range_max = 30.0F;
  scan.ranges.assign(beams, range);
  return scan;
}

TEST(RangeView, HasABeamPerDegreeWithTheNearestHit) {
  sensor::LaserScan scan = FineScan(40, 5.0F);
  scan.ranges[6] = 2.0F;
  const RangeView view = RangeView::Of(scan, {});
  ASSERT_EQ(view.ranges.size(), 10U);
  EXPECT_NEAR(view.angle_increment, kDegree, 1e-12);
  EXPECT_EQ(view.ranges[0], 5.0F);
  EXPECT_EQ(view.ranges[1], 2.0F);
  EXPECT_NEAR(view.angle_min, 1.5 * kDegree / 4.0, 1e-9) << "the middle of the four beams";
}

TEST(RangeView, NoReturnIsInfiniteAndUnknownIsNan) {
  sensor::LaserScan scan = FineScan(16, kUnknown);
  std::fill_n(scan.ranges.begin() + 4, 4, kInfinite);
  scan.ranges[9] = kInfinite;  // among unknown beams
  scan.ranges[12] = kInfinite;
  scan.ranges[13] = 4.0F;
  const RangeView view = RangeView::Of(scan, {});
  ASSERT_EQ(view.ranges.size(), 4U);
  EXPECT_TRUE(std::isnan(view.ranges[0]));
  EXPECT_EQ(view.ranges[1], kInfinite);
  EXPECT_EQ(view.ranges[2], kInfinite);
  EXPECT_EQ(view.ranges[3], 4.0F);
}

TEST(RangeView, AClockwiseScannerGivesTheSameView) {
  sensor::LaserScan scan = FineScan(80, 5.0F);
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) scan.ranges[i] += 0.01F * static_cast<float>(i);
  sensor::LaserScan reversed = scan;
  std::reverse(reversed.ranges.begin(), reversed.ranges.end());
  reversed.angle_min = scan.angle(scan.ranges.size() - 1);
  reversed.angle_increment = -scan.angle_increment;
  const RangeView a = RangeView::Of(scan, {1, 2, 0.5});
  const RangeView b = RangeView::Of(reversed, {1, 2, 0.5});
  EXPECT_EQ(a.ranges, b.ranges);
  EXPECT_NEAR(a.angle_min, b.angle_min, 1e-9);
  EXPECT_NEAR(a.angle_increment, b.angle_increment, 1e-12);
}

TEST(RangeView, CoarseScansKeepTheirBeamsAndTheScannersMountCounts) {
  sensor::LaserScan scan = FineScan(5, 3.0F);
  scan.angle_increment = 10 * kDegree;
  scan.T_robot_laser = {0.2, 0, M_PI_2};
  const RangeView view = RangeView::Of(scan, {1, 2, 0});
  EXPECT_EQ(view.ranges.size(), 5U);
  EXPECT_NEAR(view.angle_increment, 10 * kDegree, 1e-12);
  EXPECT_THAT(view.T_odom_laser, enfilade::testing::PoseNear(Pose2{1.2, 2, M_PI_2}, 1e-12, 1e-12));
}

TEST(RangeView, ComesBackFromItsBytes) {
  const RangeView view = RangeView::Of(FineScan(21, 2.5F), {1, 2, 0.3});
  std::string bytes;
  BinaryWriter writer(bytes);
  PutView(writer, view);
  BinaryReader reader(bytes);
  const RangeView again = GetView(reader);
  EXPECT_TRUE(reader.ok() && reader.at_end());
  EXPECT_EQ(again.time, view.time);
  EXPECT_EQ(again.T_odom_robot, view.T_odom_robot);
  EXPECT_EQ(again.T_odom_laser, view.T_odom_laser);
  EXPECT_EQ(again.angle_min, view.angle_min);
  EXPECT_EQ(again.angle_increment, view.angle_increment);
  EXPECT_EQ(again.ranges, view.ranges);
}

// A room 6 m x 4 m, cut in two by a wall at x = 0 with a gap of `width` in the middle.
RangeView ViewIn(double width, double x) {
  std::vector<Segment> walls = {{{-3, -2}, {3, -2}}, {{3, -2}, {3, 2}}, {{3, 2}, {-3, 2}}, {{-3, 2}, {-3, -2}}};
  walls.push_back({{0, width / 2}, {0, 2}});
  walls.push_back({{0, -width / 2}, {0, -2}});
  return RangeView::Of(ScanOf(walls, {x, 0}), {x, 0, 0});
}

HiddenGround Compare(double width, double from, double to) {
  return CompareGround(ViewIn(width, from), ViewIn(width, to), {0, width / 2}, {0, -width / 2}, 4.0);
}

TEST(CompareGround, TheNarrowerTheDoorTheMoreGroundItHides) {
  double before = -1.0;
  for (const double width : {3.6, 2.0, 1.2, 0.8}) {
    const HiddenGround ground = Compare(width, -1.0, 1.0);
    EXPECT_GT(ground.seen, 8.0) << "half the room";
    EXPECT_LE(ground.compared, ground.seen);
    EXPECT_LE(ground.hidden, ground.compared);
    EXPECT_GT(ground.hidden / ground.compared, before) << width;
    before = ground.hidden / ground.compared;
  }
  EXPECT_GT(before, 0.4);
}

TEST(CompareGround, AViewHidesNothingFromItself) {
  const HiddenGround ground = Compare(1.0, -1.0, -1.0);
  EXPECT_GT(ground.seen, 5.0);
  EXPECT_NEAR(ground.compared, ground.seen, 0.05 * ground.seen);
  EXPECT_LT(ground.hidden, 0.05 * ground.seen);
}

TEST(CompareGround, BothSidesOfASymmetricDoorHideTheSame) {
  const HiddenGround west = Compare(1.0, -1.0, 1.0);
  const HiddenGround east = Compare(1.0, 1.0, -1.0);
  EXPECT_NEAR(west.hidden / west.compared, east.hidden / east.compared, 0.03);
}

TEST(CompareGround, GroundOutsideTheOthersFieldOfViewIsNotCompared) {
  RangeView ahead_only = ViewIn(1.0, 1.0);
  // Only beams that look east, away from the door.
  const auto beams = ahead_only.ranges.size();
  for (std::size_t i = 0; i < beams; ++i) {
    const double bearing = ahead_only.angle_min + ahead_only.angle_increment * static_cast<double>(i);
    if (std::abs(bearing) > M_PI_2) ahead_only.ranges[i] = kUnknown;
  }
  const HiddenGround ground = CompareGround(ViewIn(1.0, -1.0), ahead_only, {0, 0.5}, {0, -0.5}, 4.0);
  EXPECT_GT(ground.seen, 8.0);
  EXPECT_EQ(ground.compared, 0.0);
  EXPECT_EQ(ground.hidden, 0.0);
}

TEST(CompareGround, AViewWithoutBeamsComparesNothing) {
  EXPECT_EQ(CompareGround(ViewIn(1.0, -1.0), RangeView(), {0, 0.5}, {0, -0.5}, 4.0).compared, 0.0);
  EXPECT_EQ(CompareGround(RangeView(), ViewIn(1.0, 1.0), {0, 0.5}, {0, -0.5}, 4.0).seen, 0.0);
}

}  // namespace
}  // namespace enfilade::doors
