// SPDX-License-Identifier: Apache-2.0
#include "core/localization/recent_scans.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace enfilade::localization {
namespace {

using ::testing::ElementsAre;
using ::testing::SizeIs;

sensor::PairedScan ScanAt(double seconds, std::optional<Pose2> T_odom_robot) {
  sensor::PairedScan scan;
  scan.scan.time = static_cast<TimeNs>(seconds * 1e9);
  scan.T_odom_robot = T_odom_robot;
  return scan;
}

// Along x, five scans a second, each 0.125 m on; the moments (s) at which an attempt is due.
std::vector<double> DueWhile(RecentScans& recent, double from, double to) {
  std::vector<double> due;
  for (int i = static_cast<int>(5.0 * from); i < static_cast<int>(5.0 * to); ++i) {
    if (recent.Add(ScanAt(i / 5.0, Pose2{0.125 * i, 0.0, 0.0}))) due.push_back(i / 5.0);
  }
  return due;
}

TEST(RecentScans, AnAttemptIsDueAtTheFirstScanAndEveryMetre) {
  RecentScans recent;
  EXPECT_THAT(DueWhile(recent, 0.0, 6.6), ElementsAre(0.0, 1.6, 3.2, 4.8, 6.4));
  EXPECT_NEAR(recent.travelled(), 4.0, 1e-9) << "from the first scan to that at 6.4 s";
  EXPECT_NEAR(recent.seconds(), 6.4, 1e-9);
}

TEST(RecentScans, KeepsTheLastMetresAndAlwaysTheLastScan) {
  RecentScans recent({.window = 2.0, .scan_spacing = 0.25});
  DueWhile(recent, 0.0, 60.0);
  EXPECT_NEAR(recent.scans().back().T_odom_robot->x, 37.375, 1e-9);
  EXPECT_GE(recent.scans().front().T_odom_robot->x, 35.375 - 1e-9);
  EXPECT_LE(recent.scans().size(), 9U);
  EXPECT_GE(recent.scans().size(), 7U);
}

TEST(RecentScans, ATurnIsWorthAnAttemptAndStandingIsNot) {
  RecentScans recent;
  EXPECT_TRUE(recent.Add(ScanAt(0.0, Pose2{})));
  for (int i = 1; i < 100; ++i) EXPECT_FALSE(recent.Add(ScanAt(i, Pose2{})));
  EXPECT_THAT(recent.scans(), SizeIs(2)) << "the first and the last";
  EXPECT_TRUE(recent.Add(ScanAt(100.0, Pose2{0.0, 0.0, 1.2})));
}

TEST(RecentScans, WhatCouldNotBeTriedIsTriedAgainSoon) {
  RecentScans recent;
  EXPECT_TRUE(recent.Add(ScanAt(0.0, Pose2{})));
  recent.Retry();
  EXPECT_FALSE(recent.Add(ScanAt(1.0, Pose2{})));
  EXPECT_TRUE(recent.Add(ScanAt(2.0, Pose2{})));
  EXPECT_FALSE(recent.Add(ScanAt(10.0, Pose2{}))) << "once";
}

TEST(RecentScans, WithoutOdometryOnlyTheFirstScanIsWorthAnAttempt) {
  RecentScans recent;
  EXPECT_TRUE(recent.Add(ScanAt(0.0, std::nullopt)));
  for (int i = 1; i < 50; ++i) EXPECT_FALSE(recent.Add(ScanAt(i, std::nullopt)));
  EXPECT_THAT(recent.scans(), SizeIs(1));
  EXPECT_TRUE(recent.Add(ScanAt(50.0, Pose2{}))) << "odometry begins";
  EXPECT_FALSE(recent.Add(ScanAt(51.0, std::nullopt)));
  EXPECT_TRUE(recent.T_odom_robot());
}

}  // namespace
}  // namespace enfilade::localization
