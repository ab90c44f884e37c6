// SPDX-License-Identifier: Apache-2.0
#include "server/app/survey/growing_drive.h"

#include <algorithm>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/server/app/drawn_drive.h"

namespace enfilade::server {
namespace {

using localization::DrawnMap;

std::vector<Pose2> Round() {
  return {{1.5, 2.5, 0.0}, {4.5, 2.8, 0.0}, {4.5, 2.8, 3.1}, {1.5, 2.5, 3.1}, {1.5, 2.5, 0.0}, {4.5, 2.8, 0.0}};
}

void ExpectEqual(const MappedDrive& a, const MappedDrive& b) {
  EXPECT_EQ(a.grid, b.grid);
  EXPECT_EQ(a.variance_factor, b.variance_factor);
  ASSERT_EQ(a.trajectory.size(), b.trajectory.size());
  for (std::size_t i = 0; i < a.trajectory.size(); ++i) {
    EXPECT_EQ(a.trajectory[i].time, b.trajectory[i].time);
    EXPECT_EQ(a.trajectory[i].T_map_robot, b.trajectory[i].T_map_robot);
  }
}

// Of the log's scans, the first and each `every`th after it are keyframes.
GrowingDrive::Feed FeedOf(std::span<const sensor::Record> records, std::int64_t every = 1) {
  return [records, every](const GrowingDrive::Add& add) {
    for (const sensor::Record& record : records) add(record, (record.sequence / 2 - 1) % every == 0);
    return absl::OkStatus();
  };
}

// Asking for the map in between must not change what comes out in the end.
void ExpectSameAsAtOnce(const std::optional<slam::ExistingMap>& existing, std::int64_t every = 1) {
  const DrawnMap room = localization::UniqueRoom();
  const std::vector<sensor::Record> log = RecordDrive(room, Round());
  slam::SlamOptions slam;
  slam.submap.max_keyframes = 8;  // several submaps
  const absl::StatusOr<MappedDrive> expected = GrowingDrive({}, slam, existing).Extend(FeedOf(log, every));
  ASSERT_OK(expected);
  ASSERT_GT(expected->trajectory.size(), 25U);

  GrowingDrive parts({}, slam, existing);
  std::size_t before = 0;
  const std::size_t size = log.size() / 5 + 1;
  absl::StatusOr<MappedDrive> grown = MappedDrive{};
  for (std::size_t i = 0; i < log.size(); i += size) {
    grown = parts.Extend(FeedOf(std::span(log).subspan(i, std::min(size, log.size() - i)), every));
    ASSERT_OK(grown);
    EXPECT_GT(grown->trajectory.size(), before);
    before = grown->trajectory.size();
  }
  ExpectEqual(*grown, *expected);
  const absl::StatusOr<MappedDrive> again = parts.Extend(FeedOf({}));
  ASSERT_OK(again);
  ExpectEqual(*again, *expected);
}

TEST(GrowingDrive, GrowsIntoTheMapOfTheWholeDrive) { ExpectSameAsAtOnce(std::nullopt); }

TEST(GrowingDrive, GrowsByKeyframesAsWell) { ExpectSameAsAtOnce(std::nullopt, 4); }

TEST(GrowingDrive, KeyframesAloneGiveTheSameMapAndTheLastScanItsEnd) {
  const DrawnMap room = localization::UniqueRoom();
  const std::vector<sensor::Record> log = RecordDrive(room, Round());
  const absl::StatusOr<MappedDrive> all = GrowingDrive({}, {}, std::nullopt).Extend(FeedOf(log));
  const absl::StatusOr<MappedDrive> few = GrowingDrive({}, {}, std::nullopt).Extend(FeedOf(log, 4));
  ASSERT_OK(all);
  ASSERT_OK(few);
  EXPECT_LT(few->trajectory.size(), all->trajectory.size() / 3);
  for (const slam::StampedPose& pose : few->trajectory) {
    const auto same = std::find_if(all->trajectory.begin(), all->trajectory.end(),
                                   [&](const slam::StampedPose& one) { return one.time == pose.time; });
    ASSERT_NE(same, all->trajectory.end());
    EXPECT_LT(Between(same->T_map_robot, pose.T_map_robot).translation().norm(), 0.05);
    EXPECT_LT(std::abs(Between(same->T_map_robot, pose.T_map_robot).yaw), 0.02);
  }
  EXPECT_NE((log.back().sequence / 2 - 1) % 4, 0) << "the last scan is no keyframe";
  EXPECT_EQ(few->trajectory.back().time, all->trajectory.back().time);
}

TEST(GrowingDrive, GrowsInAnExistingMap) {
  const DrawnMap room = localization::UniqueRoom();
  PoseWithCovariance start{Round().front(), Eigen::Matrix3d::Identity() * 1e-3};
  ExpectSameAsAtOnce(slam::ExistingMap{room.Grid(), {start, std::nullopt}});
}

TEST(GrowingDrive, WithoutRecordsHasNoMap) {
  const absl::StatusOr<MappedDrive> mapped = GrowingDrive({}, {}, std::nullopt).Extend(FeedOf({}));
  ASSERT_OK(mapped);
  EXPECT_TRUE(mapped->grid.cells.empty());
  EXPECT_TRUE(mapped->trajectory.empty());
}

TEST(GrowingDrive, IsAsBeforeIfRecordsCannotBeRead) {
  const std::vector<sensor::Record> log = RecordDrive(localization::UniqueRoom(), Round());
  GrowingDrive drive({}, {}, std::nullopt);
  const auto half = std::span(log).first(log.size() / 2);
  ASSERT_OK(drive.Extend(FeedOf(half)));
  const auto interrupted = [&](const GrowingDrive::Add& add) {
    FeedOf(std::span(log).subspan(log.size() / 2, 20))(add).IgnoreError();
    return absl::AbortedError("stop");
  };
  EXPECT_CODE(drive.Extend(interrupted), absl::StatusCode::kAborted);
  const absl::StatusOr<MappedDrive> whole = drive.Extend(FeedOf(std::span(log).subspan(log.size() / 2)));
  ASSERT_OK(whole);
  const absl::StatusOr<MappedDrive> expected = GrowingDrive({}, {}, std::nullopt).Extend(FeedOf(log));
  ASSERT_OK(expected);
  ExpectEqual(*whole, *expected);
}

}  // namespace
}  // namespace enfilade::server
