// SPDX-License-Identifier: Apache-2.0
#include "client/robot/agent/start_location.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

namespace enfilade::robot {
namespace {

using ::testing::HasSubstr;

sensor::PairedScan ScanAt(double seconds, double x) {
  sensor::PairedScan scan;
  scan.scan.time = static_cast<TimeNs>(seconds * 1e9);
  scan.T_odom_robot = Pose2{x, 0.0, 0.0};
  return scan;
}

StartAnswer Confident() {
  StartAnswer answer;
  answer.map = "hall";
  answer.T_map_robot.pose = {3.0, 4.0, 1.5};
  answer.confident = true;
  answer.hypotheses = 1;
  answer.maps_searched = 2;
  answer.reason = "nothing else fits";
  return answer;
}
// Rooms look alike.
StartAnswer Alike() {
  StartAnswer answer = Confident();
  answer.confident = false;
  answer.hypotheses = 2;
  answer.reason = "a place in another map fits nearly as well";
  return answer;
}
StartAnswer Nowhere() {
  StartAnswer answer;
  answer.maps_searched = 2;
  answer.reason = "no place in the maps fits the scans";
  return answer;
}

// Drives on at 0.5 m/s from `from` (m) until something is decided; every question gets the same answer.
StartDecision DriveOn(StartLocation& start, const absl::StatusOr<StartAnswer>& answer, double from = 0.0) {
  for (double x = from; x < 1000.0; x += 0.1) {
    if (start.Add(ScanAt(2.0 * x, x))) start.Answer(answer, {x, 0.0, 0.0});
    if (const auto decision = start.Decide()) return *decision;
  }
  ADD_FAILURE() << "never decided";
  return {};
}

TEST(StartLocation, AConfidentAnswerIsTheStart) {
  StartLocation start;
  ASSERT_TRUE(start.Add(ScanAt(0.0, 7.0)));
  EXPECT_FALSE(start.Decide());
  start.Answer(Confident(), {7.0, 0.0, 0.0});
  const auto decision = start.Decide();
  ASSERT_TRUE(decision);
  EXPECT_EQ(decision->map, "hall");
  EXPECT_EQ(decision->T_map_robot.pose, (Pose2{3.0, 4.0, 1.5}));
  EXPECT_EQ(decision->T_odom_robot, (Pose2{7.0, 0.0, 0.0}));
}

// The pose is that of the scan that was asked about, however far the robot has driven since.
TEST(StartLocation, ALateAnswerKeepsItsOdometry) {
  StartLocation start;
  ASSERT_TRUE(start.Add(ScanAt(0.0, 0.0)));
  for (int i = 1; i <= 30; ++i) start.Add(ScanAt(0.2 * i, 0.1 * i));
  start.Answer(Confident(), {0.0, 0.0, 0.0});
  EXPECT_EQ(start.Decide()->T_odom_robot, Pose2());
}

TEST(StartLocation, HypothesesAreKeptUntilOneIsLeft) {
  StartLocation start;
  for (double x = 0.0; x < 4.0; x += 0.1) {
    if (start.Add(ScanAt(2.0 * x, x))) start.Answer(Alike(), {x, 0.0, 0.0});
    ASSERT_FALSE(start.Decide()) << "at " << x << " m";
  }
  EXPECT_EQ(DriveOn(start, Confident(), 4.0).map, "hall");
}

TEST(StartLocation, BeginsANewMapWhereRoomsLookAlikeForTooLong) {
  StartLocation start;
  const StartDecision decision = DriveOn(start, Alike());
  EXPECT_EQ(decision.map, "");
  EXPECT_THAT(decision.reason, HasSubstr("2 places are possible"));
}

TEST(StartLocation, BeginsANewMapWhereNothingIsKnown) {
  StartLocation start;
  const StartDecision decision = DriveOn(start, Nowhere());
  EXPECT_EQ(decision.map, "");
  EXPECT_THAT(decision.reason, HasSubstr("no place in the maps"));
}

TEST(StartLocation, BeginsANewMapAtOnceInASiteWithoutMaps) {
  StartLocation start;
  ASSERT_TRUE(start.Add(ScanAt(0.0, 0.0)));
  start.Answer(StartAnswer{}, {});
  EXPECT_EQ(start.Decide()->map, "");
}

TEST(StartLocation, AsksAgainWhileTheServerIsDown) {
  StartLocation start;
  ASSERT_TRUE(start.Add(ScanAt(0.0, 0.0)));
  start.Answer(absl::UnavailableError("down"), {});
  EXPECT_FALSE(start.Decide());
  EXPECT_TRUE(start.Add(ScanAt(3.0, 0.0))) << "although it stands";
  start.Answer(Confident(), {});
  EXPECT_EQ(start.Decide()->map, "hall");
}

TEST(StartLocation, DoesNotWaitForAServerForever) {
  StartLocation start;
  EXPECT_TRUE(start.Add(ScanAt(0.0, 0.0)));
  start.Answer(absl::UnavailableError("down"), {});
  start.Add(ScanAt(59.0, 0.0));
  EXPECT_FALSE(start.Decide());
  start.Add(ScanAt(60.0, 0.0));
  EXPECT_THAT(start.Decide()->reason, HasSubstr("down"));
}

TEST(StartLocation, AnErrorThatStaysBeginsANewMap) {
  StartLocation start;
  ASSERT_TRUE(start.Add(ScanAt(0.0, 0.0)));
  start.Answer(absl::UnimplementedError("an older server"), {});
  EXPECT_EQ(start.Decide()->map, "");
}

TEST(StartLocation, ScansWithoutWallsMayBeFollowedByOthers) {
  StartLocation start;
  ASSERT_TRUE(start.Add(ScanAt(0.0, 0.0)));
  start.Answer(InvalidArgument("no scan has 30 hits"), {});
  EXPECT_FALSE(start.Decide());
  EXPECT_EQ(DriveOn(start, Confident()).map, "hall");
}

TEST(StartLocation, AtADoorTheMapIsANewOne) {
  StartLocation start;
  ASSERT_TRUE(start.Add(ScanAt(0.0, 0.0)));
  start.Answer(Alike(), {});
  EXPECT_EQ(start.DecideNow().map, "");
}

}  // namespace
}  // namespace enfilade::robot
