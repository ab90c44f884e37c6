// SPDX-License-Identifier: Apache-2.0
#include "server/app/survey/drive_location.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/support/pose_matchers.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/server/app/drawn_drive.h"

namespace enfilade::server {
namespace {

using localization::DrawnMap;
using testing::PoseNear;

const Pose2 kOdomStart{3.0, -2.0, 0.7};

std::optional<slam::ExistingMapEntry> LocateDriveIn(const DrawnMap& map, const std::vector<sensor::Record>& log) {
  DriveLocation location({}, map.Grid());
  for (const sensor::Record& record : log) EXPECT_OK(location.Add(record));
  return location.Finish();
}

// Into one of two rooms that are alike, and along the corridor.
std::vector<Pose2> WayOut() {
  return {{8.0, 2.9, -1.9}, {7.5, 1.5, -1.57}, {7.5, 0.9, -1.57}, {7.4, 0.8, 3.1},
          {1.0, 0.75, 3.1}, {1.0, 0.75, 0.0},  {6.0, 0.75, 0.0}};
}

TEST(DriveLocation, FindsADriveOfARobotThatWasRestartedElsewhere) {
  const DrawnMap rooms = localization::TwoRoomsAlike();
  const auto entry = LocateDriveIn(rooms, RecordDrive(rooms, WayOut(), kOdomStart));
  ASSERT_TRUE(entry);
  const Pose2 T_map_odom = entry->T_map_robot.pose * Inverse(*entry->T_odom_robot);
  EXPECT_THAT(T_map_odom * kOdomStart, PoseNear(WayOut().front(), 0.1, 0.03));
}

TEST(DriveLocation, LeavesADriveInOneOfTwoRoomsThatAreAlike) {
  const DrawnMap rooms = localization::TwoRoomsAlike();
  EXPECT_FALSE(LocateDriveIn(rooms, RecordDrive(rooms, {{8.0, 2.9, -1.9}, {7.8, 2.4, -1.9}})));
}

TEST(DriveLocation, LeavesADriveThroughAnotherBuilding) {
  EXPECT_FALSE(LocateDriveIn(localization::UniqueRoom(), RecordDrive(localization::TwoRoomsAlike(), WayOut())));
}

// Odometry jumps in between: the two ends of the drive contradict each other.
TEST(DriveLocation, LeavesADriveOfARobotThatWasCarried) {
  const DrawnMap room = localization::UniqueRoom();
  const std::vector<Pose2> round = {{1.5, 2.5, 0.0}, {4.5, 2.8, 0.0}, {4.5, 2.8, 3.1},
                                    {1.5, 2.5, 3.1}, {1.5, 2.5, 0.0}, {4.5, 2.8, 0.0}};
  std::vector<sensor::Record> log = RecordDrive(room, round, kOdomStart);
  ASSERT_TRUE(LocateDriveIn(room, log)) << "without the jump";
  const TimeNs middle = sensor::TimeOf(log[log.size() / 2].payload);
  for (sensor::Record& record : log) {
    auto* odometry = std::get_if<sensor::Odometry>(&record.payload);
    if (odometry && odometry->time > middle) odometry->T_odom_robot = Pose2{9.0, 3.0, 2.0} * odometry->T_odom_robot;
  }
  EXPECT_FALSE(LocateDriveIn(room, log));
}

TEST(DriveLocation, WithoutOdometryADriveIsNotLocated) {
  const DrawnMap room = localization::UniqueRoom();
  EXPECT_FALSE(LocateDriveIn(room, RecordDrive(room, {{1.5, 2.5, 0.0}, {4.5, 2.8, 0.0}}, {}, false)));
}

}  // namespace
}  // namespace enfilade::server
