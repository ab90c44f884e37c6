// SPDX-License-Identifier: Apache-2.0
#include "client/robot/agent/continuity.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/unit/core/localization/drawn_map.h"

namespace enfilade::robot {
namespace {

using localization::DrawnMap;
using ::testing::HasSubstr;

class ContinuityTest : public ::testing::Test {
 protected:
  // Drives from pose to pose in steps of 0.1 m and 0.1 rad, with right odometry. The first reason for a break.
  std::optional<std::string> Drive(const DrawnMap& map, const std::vector<Pose2>& way,
                                   double field_of_view = 2.0 * M_PI) {
    std::optional<std::string> broken;
    for (std::size_t i = 1; i < way.size(); ++i) {
      const Pose2 motion = Between(way[i - 1], way[i]);
      const double steps = std::ceil(std::max(motion.translation().norm(), std::abs(motion.yaw)) / 0.1);
      for (double step = 0.0; step <= steps; step += 1.0) {
        const Pose2 pose = Interpolate(way[i - 1], way[i], step / steps);
        if (step > 0.0) odometry_ = odometry_ * Between(last_, pose);
        last_ = pose;
        if (const auto now = See(map.Scan(pose, field_of_view)); now && !broken) broken = now;
      }
    }
    return broken;
  }
  std::optional<std::string> See(sensor::LaserScan scan) {
    scan.time = time_ += kNsPerSecond / 5;
    return continuity_.Add(scan, odometry_);
  }

  const DrawnMap room_ = localization::UniqueRoom();
  const DrawnMap rooms_ = localization::TwoRoomsAlike();
  Continuity continuity_;
  Pose2 odometry_{3.0, -2.0, 0.7};
  Pose2 last_;
  TimeNs time_ = kNsPerSecond;
};

TEST_F(ContinuityTest, DrivingThroughDoorsAndTurningContinues) {
  const std::vector<Pose2> way = {{8.0, 2.9, -1.9}, {7.5, 1.5, -1.57}, {7.5, 0.9, -1.57}, {7.4, 0.8, 3.1},
                                  {3.0, 0.75, 3.1}, {2.3, 0.9, 1.57},  {2.3, 2.5, 1.57},  {2.3, 2.5, -1.57}};
  EXPECT_FALSE(Drive(rooms_, way));
  EXPECT_TRUE(continuity_.settled());
}

TEST_F(ContinuityTest, SoItDoesWithAScannerThatLooksAhead) {
  EXPECT_FALSE(Drive(room_, {{1.5, 2.5, 0.0}, {4.5, 2.8, 0.0}, {4.5, 2.8, 3.1}, {1.5, 2.5, 3.1}}, M_PI));
}

TEST_F(ContinuityTest, ARobotThatIsCarriedWhileOdometryStandsStillIsNoticed) {
  ASSERT_FALSE(Drive(room_, {{1.5, 2.5, 0.0}, {3.0, 2.5, 0.0}}));
  last_ = {6.0, 4.0, 1.6};
  const auto broken = Drive(room_, {{6.0, 4.0, 1.6}, {6.0, 3.3, 1.6}});
  ASSERT_TRUE(broken);
  EXPECT_THAT(*broken, HasSubstr("carried"));
  EXPECT_TRUE(continuity_.settled()) << "it drives again";
  EXPECT_FALSE(continuity_.suspicious()) << "it is known";
  EXPECT_FALSE(Drive(room_, {{6.0, 3.3, 1.6}, {6.0, 2.6, 1.6}})) << "once";
}

// Less than half of what it sees contradicts.
TEST_F(ContinuityTest, SoItIsIfThePlacesAreHalfAlike) {
  ASSERT_FALSE(Drive(room_, {{6.0, 2.5, 1.57}, {6.0, 1.5, 1.57}}));
  last_ = {2.5, 4.0, 0.0};
  EXPECT_TRUE(Drive(room_, {{2.5, 4.0, 0.0}, {2.9, 4.0, 0.0}}));
}

TEST_F(ContinuityTest, SoItIsIfItTurnsAtOnce) {
  ASSERT_FALSE(Drive(room_, {{1.5, 2.5, 0.0}, {3.0, 2.5, 0.0}}));
  const Pose2 turn{0.0, 0.0, 0.25};
  last_ = {6.0, 4.0, 1.6};
  std::optional<std::string> broken = See(room_.Scan(last_));
  for (int scan = 0; scan < 3 && !broken; ++scan) {
    last_ = last_ * turn;
    odometry_ = odometry_ * turn;
    broken = See(room_.Scan(last_));
  }
  EXPECT_TRUE(broken);
}

TEST_F(ContinuityTest, WheelsThatSlipAreNoBreak) {
  ASSERT_FALSE(Drive(room_, {{1.8, 2.4, -1.57}, {1.8, 1.4, -1.57}}));
  odometry_ = odometry_ * Pose2{-0.3, 0.3, 0.0};
  for (int i = 0; i < 5; ++i) EXPECT_FALSE(See(room_.Scan(last_)));
}

// It hides much, but nothing is where it was.
TEST_F(ContinuityTest, SomebodyWhoComesNearIsNoBreak) {
  ASSERT_FALSE(Drive(room_, {{1.5, 2.5, 0.0}, {3.0, 2.5, 0.0}}));
  for (int i = 0; i < 10; ++i) {
    sensor::LaserScan scan = room_.Scan(last_);
    for (std::size_t beam = 110; beam < 250; ++beam) scan.ranges[beam] = 0.5F;
    EXPECT_FALSE(See(scan));
  }
}

TEST_F(ContinuityTest, AJumpOfOdometryIsNoticedAtOnce) {
  ASSERT_FALSE(Drive(room_, {{1.5, 2.5, 0.0}, {3.0, 2.5, 0.0}}));
  odometry_ = Pose2{20.0, -7.0, 2.0} * odometry_;
  const auto broken = See(room_.Scan(last_));
  ASSERT_TRUE(broken);
  EXPECT_THAT(*broken, HasSubstr("odometry jumps"));
  EXPECT_FALSE(continuity_.settled());
}

TEST_F(ContinuityTest, OdometryThatNeverMovesSaysNothing) {
  for (double yaw = 0.0; yaw < 6.0; yaw += 0.3) EXPECT_FALSE(See(room_.Scan({1.5, 2.5, yaw})));
}

TEST_F(ContinuityTest, OneBadScanIsNoBreak) {
  ASSERT_FALSE(Drive(room_, {{1.5, 2.5, 0.0}, {3.0, 2.5, 0.0}}));
  EXPECT_FALSE(See(room_.Scan({7.3, 3.5, 2.0})));
  EXPECT_FALSE(Drive(room_, {{3.0, 2.5, 0.0}, {4.0, 2.5, 0.0}}));
}

TEST_F(ContinuityTest, DrivingBlindIsNoticedAfterSomeMetresAndStandingBlindIsNot) {
  ASSERT_FALSE(Drive(room_, {{1.5, 2.5, 0.0}, {3.0, 2.5, 0.0}}));
  sensor::LaserScan nothing = room_.Scan(last_);
  nothing.ranges.assign(nothing.ranges.size(), std::numeric_limits<float>::infinity());
  for (int i = 0; i < 300; ++i) EXPECT_FALSE(See(nothing));
  std::optional<std::string> broken;
  int steps = 0;
  for (; steps < 100 && !broken; ++steps) {
    odometry_ = odometry_ * Pose2{0.1, 0.0, 0.0};
    broken = See(nothing);
  }
  ASSERT_TRUE(broken);
  EXPECT_THAT(*broken, HasSubstr("no walls"));
  EXPECT_NEAR(steps, 50, 1);
  EXPECT_FALSE(continuity_.settled());
  EXPECT_FALSE(Drive(room_, {{3.0, 2.5, 0.0}, {4.0, 2.5, 0.0}}));
  EXPECT_TRUE(continuity_.settled());
}

}  // namespace
}  // namespace enfilade::robot
