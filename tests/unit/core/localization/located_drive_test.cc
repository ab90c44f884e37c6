// SPDX-License-Identifier: Apache-2.0
#include "core/localization/located_drive.h"

#include "gtest/gtest.h"

namespace enfilade::localization {
namespace {

// Odometry and map agree but for `off`.
LocatedMoment At(double travelled, const Pose2& off = {}) {
  const Pose2 T_map_odom{10.0, 5.0, 1.0};
  const Pose2 T_odom_robot{travelled, 0.0, 0.0};
  return {{T_map_odom * T_odom_robot * off, Eigen::Matrix3d::Identity() * 1e-4}, T_odom_robot, travelled};
}

TEST(FindStart, IsTheFirstOfMomentsThatAgree) {
  const auto start = FindStart({At(5.0), At(10.0, {0.3, 0.1, 0.05}), At(20.0, {0.5, 0.0, -0.1})}, 60.0);
  ASSERT_TRUE(start);
  EXPECT_EQ(start->travelled, 5.0);
}

TEST(FindStart, MomentsThatContradictEachOtherSayNothing) {
  EXPECT_FALSE(FindStart({At(5.0), At(10.0, {3.0, 0.0, 0.0}), At(15.0, {3.0, 0.0, 0.0})}, 60.0));
  EXPECT_FALSE(FindStart({At(5.0), At(10.0, {0.0, 0.0, 3.1})}, 60.0));
}

TEST(FindStart, OneIsEnoughForAShortDriveOnly) {
  EXPECT_TRUE(FindStart({At(2.0)}, 6.0));
  EXPECT_FALSE(FindStart({At(2.0)}, 60.0));
  EXPECT_FALSE(FindStart({}, 6.0));
}

}  // namespace
}  // namespace enfilade::localization
