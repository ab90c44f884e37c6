// SPDX-License-Identifier: Apache-2.0
#include "server/app/survey/growing_drive.h"

#include <optional>

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

// Asking for the map in between must not change what comes out in the end.
void ExpectSameAsAtOnce(const std::optional<slam::ExistingMap>& existing) {
  const DrawnMap room = localization::UniqueRoom();
  const std::vector<sensor::Record> log = RecordDrive(room, Round());
  slam::SlamOptions slam;
  slam.submap.max_keyframes = 8;  // several submaps
  GrowingDrive whole({}, slam, existing);
  for (const sensor::Record& record : log) whole.Add(record);
  const absl::StatusOr<MappedDrive> expected = whole.Map();
  ASSERT_OK(expected);
  ASSERT_GT(expected->trajectory.size(), 50U);

  GrowingDrive parts({}, slam, existing);
  std::size_t before = 0;
  for (std::size_t i = 0; i < log.size(); ++i) {
    if (i % (log.size() / 5) == 7) {
      const absl::StatusOr<MappedDrive> part = parts.Map();
      ASSERT_OK(part);
      EXPECT_GE(part->trajectory.size(), before);
      before = part->trajectory.size();
    }
    parts.Add(log[i]);
  }
  EXPECT_GT(before, 0U);
  const absl::StatusOr<MappedDrive> grown = parts.Map();
  ASSERT_OK(grown);
  ExpectEqual(*grown, *expected);
  const absl::StatusOr<MappedDrive> again = parts.Map();
  ASSERT_OK(again);
  ExpectEqual(*again, *expected);
}

TEST(GrowingDrive, GrowsIntoTheMapOfTheWholeDrive) { ExpectSameAsAtOnce(std::nullopt); }

TEST(GrowingDrive, GrowsInAnExistingMap) {
  const DrawnMap room = localization::UniqueRoom();
  PoseWithCovariance start{Round().front(), Eigen::Matrix3d::Identity() * 1e-3};
  ExpectSameAsAtOnce(slam::ExistingMap{room.Grid(), {start, std::nullopt}});
}

TEST(GrowingDrive, WithoutRecordsHasNoMap) {
  GrowingDrive drive({}, {}, std::nullopt);
  const absl::StatusOr<MappedDrive> mapped = drive.Map();
  ASSERT_OK(mapped);
  EXPECT_TRUE(mapped->grid.cells.empty());
  EXPECT_TRUE(mapped->trajectory.empty());
}

}  // namespace
}  // namespace enfilade::server
