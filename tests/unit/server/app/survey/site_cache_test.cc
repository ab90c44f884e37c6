// SPDX-License-Identifier: Apache-2.0
#include "server/app/survey/site_cache.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/core/localization/drawn_map.h"

namespace enfilade::server {
namespace {

TEST(RoomCache, FindsRoomsAgainWhenTheLevelHasChanged) {
  const grid::OccupancyGrid rooms = localization::TwoRoomsAlike().Grid();
  const std::vector<Eigen::Vector2d> way{{1.0, 0.75}, {6.0, 0.75}};
  RoomCache cache;
  const auto expect_as_without = [&](const grid::OccupancyGrid& grid, const std::vector<Eigen::Vector2d>& trajectory) {
    const rooms::RoomPartition expected = rooms::PartitionRooms(grid, {}, {.passages = {}, .trajectory = trajectory});
    for (int i = 0; i < 2; ++i) {
      const rooms::RoomPartition& found = cache.Get(grid, {}, trajectory);
      EXPECT_EQ(found.labels, expected.labels);
      EXPECT_EQ(found.rooms.size(), expected.rooms.size());
    }
  };
  expect_as_without(rooms, way);
  expect_as_without(rooms, {{1.0, 0.75}});
  expect_as_without(localization::UniqueRoom().Grid(), way);
}

// Bytes.
PackedDrive DriveOfAtLeast(std::size_t size) {
  slam::ChainedMap drive;
  drive.trajectory.resize(size / sizeof(slam::StampedPose) + 1);
  return PackedDrive(std::move(drive));
}

TEST(SiteCaches, ForgetThoseNotAskedForLongestWhenTheyDoNotFit) {
  const auto fill = [](SiteCache& cache) {
    ASSERT_OK(cache.drives.Get("a", [](CachedDrive& drive) {
      drive.mapped = DriveOfAtLeast(1000);
      return absl::OkStatus();
    }));
  };
  SiteCaches caches(3000);
  for (const char* site : {"a", "b", "c"}) {
    fill(caches.Get(SiteId(site)));
    if (std::string(site) == "b") caches.Get(SiteId("a"));
    caches.Trim();
  }
  EXPECT_EQ(caches.size(), 2U);
  EXPECT_GT(caches.Get(SiteId("a")).bytes(), 1000U);
  EXPECT_GT(caches.Get(SiteId("c")).bytes(), 1000U);
  EXPECT_EQ(caches.Get(SiteId("b")).bytes(), 0U) << "forgotten";
}

TEST(SiteCaches, KeepTheLastSiteHoweverLarge) {
  SiteCaches caches(1);
  for (const char* site : {"a", "b"}) {
    ASSERT_OK(caches.Get(SiteId(site)).drives.Get("a", [](CachedDrive& drive) {
      drive.mapped = DriveOfAtLeast(1000);
      return absl::OkStatus();
    }));
    caches.Trim();
  }
  EXPECT_EQ(caches.size(), 1U);
  EXPECT_GT(caches.Get(SiteId("b")).bytes(), 1000U);
}

}  // namespace
}  // namespace enfilade::server
