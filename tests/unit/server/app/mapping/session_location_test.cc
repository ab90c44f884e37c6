// SPDX-License-Identifier: Apache-2.0
#include "server/app/mapping/session_location.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/support/pose_matchers.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/server/app/drawn_drive.h"

namespace enfilade::server {
namespace {

using localization::DrawnMap;
using ::testing::HasSubstr;
using testing::PoseNear;

// The outcome of a whole log. `located_at`: the number of records needed.
struct Outcome {
  absl::Status status;
  std::optional<slam::ExistingMapEntry> entry;
  std::size_t located_at = 0;
};

Outcome LocateIn(const DrawnMap& map, const std::vector<sensor::Record>& log) {
  SessionLocation location({}, map.Grid());
  Outcome outcome;
  for (const sensor::Record& record : log) {
    ++outcome.located_at;
    outcome.status = location.Add(record);
    if (!outcome.status.ok()) return outcome;
    if (auto located = location.TakeLocated()) {
      outcome.entry = located->entry;
      EXPECT_FALSE(located->grid.cells.empty());
      return outcome;
    }
  }
  outcome.status = location.Finish();
  if (auto located = location.TakeLocated()) outcome.entry = located->entry;
  return outcome;
}

TEST(SessionLocation, LocatesByTheFirstScansWhereNothingIsTwice) {
  const Pose2 begin{1.5, 2.5, 0.3};
  const Outcome outcome =
      LocateIn(localization::UniqueRoom(), RecordDrive(localization::UniqueRoom(), {begin, {3.9, 2.5, 0.3}}));
  EXPECT_OK(outcome.status);
  ASSERT_TRUE(outcome.entry);
  EXPECT_LE(outcome.located_at, 4U);
  EXPECT_THAT(outcome.entry->T_map_robot.pose, PoseNear(begin, 0.05, 0.02));
  ASSERT_TRUE(outcome.entry->T_odom_robot);
  EXPECT_THAT(*outcome.entry->T_odom_robot, PoseNear(Pose2{3.0, -2.0, 0.7}, 1e-6, 1e-6));
}

// Inside it cannot be told which of two rooms it is: driving out of the door decides, and then of the whole log.
TEST(SessionLocation, WaitsUntilOneOfTwoRoomsThatAreAlikeIsLeft) {
  const DrawnMap rooms = localization::TwoRoomsAlike();
  const std::vector<Pose2> way = {
      {8.0, 2.9, -1.9}, {7.5, 1.5, -1.57}, {7.5, 0.9, -1.57}, {7.4, 0.8, 3.1}, {3.0, 0.75, 3.1}};
  const Outcome outcome = LocateIn(rooms, RecordDrive(rooms, way));
  EXPECT_OK(outcome.status);
  ASSERT_TRUE(outcome.entry);
  EXPECT_GT(outcome.located_at, 20U);
  const Pose2 T_map_odom = outcome.entry->T_map_robot.pose * Inverse(*outcome.entry->T_odom_robot);
  EXPECT_THAT(T_map_odom * Pose2({3.0, -2.0, 0.7}), PoseNear(way.front(), 0.1, 0.03)) << "the right room";
}

TEST(SessionLocation, ARobotThatStaysInOneOfThemIsNotLocated) {
  const DrawnMap rooms = localization::TwoRoomsAlike();
  const Outcome outcome = LocateIn(rooms, RecordDrive(rooms, {{8.0, 2.9, -1.9}, {7.8, 2.4, -1.9}, {8.0, 2.9, -1.9}}));
  EXPECT_TRUE(absl::IsFailedPrecondition(outcome.status));
  EXPECT_FALSE(outcome.entry);
  EXPECT_THAT(std::string(outcome.status.message()), HasSubstr("another place"));
  EXPECT_THAT(std::string(outcome.status.message()), HasSubstr("entry.pose_map_robot"));
}

TEST(SessionLocation, AnotherBuildingIsNotTakenForTheMap) {
  const Outcome outcome = LocateIn(localization::UniqueRoom(),
                                   RecordDrive(localization::TwoRoomsAlike(), {{1.0, 0.8, 0.0}, {6.0, 0.8, 0.0}}));
  EXPECT_TRUE(absl::IsFailedPrecondition(outcome.status)) << outcome.status;
  EXPECT_FALSE(outcome.entry);
}

TEST(SessionLocation, GivesUpAfterALongWay) {
  const DrawnMap rooms = localization::SymmetricRoom();
  std::vector<Pose2> way;
  for (int i = 0; i < 20; ++i) {
    way.push_back({2.0, 1.2, 0.0});
    way.push_back({4.0, 1.2, 0.0});
  }
  const std::vector<sensor::Record> log = RecordDrive(rooms, way);
  const Outcome outcome = LocateIn(rooms, log);
  EXPECT_TRUE(absl::IsFailedPrecondition(outcome.status));
  EXPECT_LT(outcome.located_at, log.size()) << "before the end";
}

TEST(SessionLocation, WithoutOdometryTheFirstScanDecides) {
  const DrawnMap room = localization::UniqueRoom();
  const Pose2 begin{1.5, 2.5, 0.3};
  const Outcome outcome = LocateIn(room, RecordDrive(room, {begin, {3.9, 2.5, 0.3}}, {}, false));
  ASSERT_TRUE(outcome.entry) << outcome.status;
  EXPECT_FALSE(outcome.entry->T_odom_robot) << "the pose is that of the first scan";
  EXPECT_THAT(outcome.entry->T_map_robot.pose, PoseNear(begin, 0.05, 0.02));
}

TEST(SessionLocation, ScansWithoutWallsLocateNothing) {
  std::vector<sensor::Record> log = RecordDrive(localization::UniqueRoom(), {{1.5, 2.5, 0.0}, {3.9, 2.5, 0.0}});
  for (sensor::Record& record : log) {
    auto* scan = std::get_if<sensor::LaserScan>(&record.payload);
    if (scan) scan->ranges.assign(scan->ranges.size(), std::numeric_limits<float>::infinity());
  }
  EXPECT_TRUE(absl::IsFailedPrecondition(LocateIn(localization::UniqueRoom(), log).status));
}

TEST(SessionLocation, WithoutScansThereIsNothingToLocate) {
  SessionLocation location({}, localization::UniqueRoom().Grid());
  EXPECT_OK(location.Add({1, sensor::Odometry{kNsPerSecond, {}}}));
  EXPECT_OK(location.Finish());
  EXPECT_TRUE(location.has_no_scans());
  EXPECT_FALSE(location.TakeLocated());
}

}  // namespace
}  // namespace enfilade::server
