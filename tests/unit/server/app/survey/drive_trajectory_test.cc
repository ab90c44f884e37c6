// SPDX-License-Identifier: Apache-2.0
#include "server/app/survey/drive_trajectory.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "tests/support/pose_matchers.h"

namespace enfilade::server {
namespace {

using testing::PoseNear;

constexpr TimeNs kSecond = 1'000'000'000;

// 1 m/s along x, a scan a second.
DriveTrajectory Straight() {
  DriveTrajectory trajectory;
  for (int i = 0; i < 5; ++i) trajectory.push_back({i * kSecond, Pose2{static_cast<double>(i), 0.0, 0.0}});
  return trajectory;
}

sensor::DoorReport Report() {
  sensor::DoorReport report;
  report.time = 4 * kSecond;
  report.door_time = 2 * kSecond;
  report.T_odom_door = {12.0, 5.2, M_PI / 2.0 + 0.3};
  report.width = 0.8;
  return report;
}

TEST(PoseAt, LiesBetweenTheScansBeforeAndAfter) {
  EXPECT_THAT(PoseAt(Straight(), 3 * kSecond / 2), PoseNear(Pose2{1.5, 0.0, 0.0}, 1e-9, 1e-9));
  EXPECT_THAT(PoseAt(Straight(), 2 * kSecond), PoseNear(Pose2{2.0, 0.0, 0.0}, 1e-9, 1e-9));
  EXPECT_THAT(PoseAt(Straight(), -kSecond), PoseNear(Pose2{0.0, 0.0, 0.0}, 1e-9, 1e-9));
  EXPECT_THAT(PoseAt(Straight(), 9 * kSecond), PoseNear(Pose2{4.0, 0.0, 0.0}, 1e-9, 1e-9));
}

TEST(PassageAt, ADoorIsWhereTheDetectorMeasuredIt) {
  // When it made the report the robot was at (12, 7) of its odometry frame, heading along y.
  const ReportedDoor door = ToReportedDoor(Report(), Pose2{12.0, 7.0, M_PI / 2.0});
  const rooms::PassageHint passage = PassageAt(Straight(), door).value();
  const Eigen::Vector2d middle = (passage.a + passage.b) / 2.0;
  EXPECT_NEAR(middle.x(), 4.0 - 1.8, 1e-9);
  EXPECT_NEAR(middle.y(), 0.0, 1e-9);
  EXPECT_NEAR((passage.b - passage.a).norm(), 0.8, 1e-9);
  const Eigen::Vector2d through(std::cos(0.3), std::sin(0.3));
  EXPECT_NEAR((passage.b - passage.a).dot(through), 0.0, 1e-9) << "across the door, not across the robot's way";
}

TEST(PassageAt, WithoutOdometryADoorIsWhereTheRobotWas) {
  sensor::DoorReport report = Report();
  report.width = 0.0;
  const rooms::PassageHint passage = PassageAt(Straight(), ToReportedDoor(report, std::nullopt)).value();
  EXPECT_NEAR(((passage.a + passage.b) / 2.0 - Eigen::Vector2d(2.0, 0.0)).norm(), 0.0, 1e-9);
  EXPECT_NEAR((passage.b - passage.a).norm(), 1.0, 1e-9) << "a usual width";
}

TEST(PassageAt, ADoorToAnotherLevelIsWhereTheRobotWas) {
  DriveTrajectory until_door = Straight();
  until_door.resize(3);  // what is beyond is not of this level
  const ReportedDoor door = ToReportedDoor(Report(), Pose2{12.0, 7.0, M_PI / 2.0});
  const rooms::PassageHint passage = PassageAt(until_door, door).value();
  EXPECT_NEAR(((passage.a + passage.b) / 2.0 - Eigen::Vector2d(2.0, 0.0)).norm(), 0.0, 1e-9);
}

TEST(PassageAt, ADoorThatTheRobotReachedOnAnotherLevelIsNotOnThisOne) {
  DriveTrajectory until_ride = Straight();
  until_ride.resize(2);
  EXPECT_EQ(PassageAt(until_ride, ToReportedDoor(Report(), Pose2{12.0, 7.0, M_PI / 2.0})), std::nullopt);
}

TEST(PlaceVisits, ThoseWithoutAScanAreDropped) {
  survey::Drive drive(2);
  drive[0].visits = {{1, kSecond, {}, {}}, {2, kSecond + 1, {}, {}}};
  drive[1].T_map_entry = Pose2{0.5, 0.0, 0.0};
  PlaceVisits(Straight(), drive);
  ASSERT_EQ(drive[0].visits.size(), 1U);
  EXPECT_THAT(drive[0].visits[0].T_level_robot, PoseNear(Pose2{1.0, 0.0, 0.0}, 1e-9, 1e-9));
  ASSERT_EQ(drive[1].visits.size(), 1U) << "where the one before it ended";
  EXPECT_THAT(drive[1].visits[0].T_level_robot, PoseNear(Pose2{1.0, 0.0, 0.0}, 1e-9, 1e-9));
}

}  // namespace
}  // namespace enfilade::server
