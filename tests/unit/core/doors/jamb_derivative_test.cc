// SPDX-License-Identifier: Apache-2.0
#include "core/doors/jamb_derivative.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/unit/core/doors/door_scan.h"

namespace enfilade::doors {
namespace {

TEST(JambDerivative, FindsADoorAhead) {
  const JambSearch search = FindJambsAhead(DoorScan(0.0, 36.0), {});
  ASSERT_TRUE(search.jambs.has_value()) << search.reason;
  EXPECT_NEAR(search.jambs->opening / kDegree, 36.0, 10.0);
  EXPECT_LT(search.jambs->right, 0.0);
  EXPECT_GT(search.jambs->left, 0.0);
  EXPECT_FALSE(FindJambsBehind(DoorScan(0.0, 36.0), {}).jambs.has_value());
}

TEST(JambDerivative, FindsADoorBehindAcrossTheScansSeam) {
  const JambSearch search = FindJambsBehind(DoorScan(M_PI, 36.0), {});
  ASSERT_TRUE(search.jambs.has_value()) << search.reason;
  EXPECT_NEAR(search.jambs->opening / kDegree, 36.0, 12.0);
  EXPECT_FALSE(FindJambsAhead(DoorScan(M_PI, 36.0), {}).jambs.has_value());
}

TEST(JambDerivative, RefusesOpeningsOutOfBounds) {
  EXPECT_FALSE(FindJambsAhead(DoorScan(0.0, 8.0), {}).jambs.has_value());
  EXPECT_FALSE(FindJambsAhead(DoorScan(0.0, 75.0), {}).jambs.has_value());
  DerivativeOptions wide;
  wide.opening_max = 120.0;
  wide.front_sector = 80.0;
  EXPECT_TRUE(FindJambsAhead(DoorScan(0.0, 75.0), wide).jambs.has_value());
}

TEST(JambDerivative, ReadsAClockwiseScannerAndItsMount) {
  sensor::LaserScan scan = DoorScan(0.0, 36.0);
  std::reverse(scan.ranges.begin(), scan.ranges.end());
  scan.angle_min = scan.angle(719);
  scan.angle_increment = -scan.angle_increment;
  EXPECT_TRUE(FindJambsAhead(scan, {}).jambs.has_value());
  sensor::LaserScan turned = DoorScan(M_PI / 2.0, 36.0);
  turned.T_robot_laser.yaw = -M_PI / 2.0;
  EXPECT_TRUE(FindJambsAhead(turned, {}).jambs.has_value());
}

// The window must not reach beyond the array.
TEST(JambDerivative, ClampsItsWindowsAtTheScansEnds) {
  for (const std::size_t beams : {1U, 2U, 5U, 9U, 19U}) {
    sensor::LaserScan scan = DoorScan(0.0, 36.0);
    scan.ranges.resize(beams);
    EXPECT_EQ(ScanDerivative(scan, {}).size(), beams);
    EXPECT_FALSE(FindJambsAhead(scan, {}).jambs.has_value());
    EXPECT_FALSE(FindJambsBehind(scan, {}).jambs.has_value());
  }
}

// Differences of infinite and NaN ranges must not count as posts.
TEST(JambDerivative, InfiniteAndUnknownBeamsAreNoPosts) {
  sensor::LaserScan scan = DoorScan(0.0, 36.0);
  std::fill(scan.ranges.begin(), scan.ranges.end(), std::numeric_limits<float>::infinity());
  EXPECT_FALSE(FindJambsAhead(scan, {}).jambs.has_value());
  std::fill(scan.ranges.begin(), scan.ranges.end(), std::numeric_limits<float>::quiet_NaN());
  EXPECT_FALSE(FindJambsAhead(scan, {}).jambs.has_value());
  // Open ground behind a door gives no return, and is a door all the same.
  sensor::LaserScan open = DoorScan(0.0, 36.0);
  for (float& range : open.ranges) {
    if (range > 4.0F) range = std::numeric_limits<float>::infinity();
  }
  EXPECT_TRUE(FindJambsAhead(open, {}).jambs.has_value());
}

TEST(JambDerivative, SaysWhereAScannerDoesNotLook) {
  sensor::LaserScan front = DoorScan(0.0, 36.0);
  front.angle_min = -M_PI / 2.0;
  front.ranges = std::vector<float>(front.ranges.begin() + 180, front.ranges.begin() + 540);
  EXPECT_TRUE(FindJambsAhead(front, {}).jambs.has_value());
  const JambSearch behind = FindJambsBehind(front, {});
  EXPECT_FALSE(behind.sector_in_view);
  EXPECT_NE(behind.reason.find("does not look back"), std::string::npos);
}

}  // namespace
}  // namespace enfilade::doors
