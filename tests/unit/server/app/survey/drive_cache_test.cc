// SPDX-License-Identifier: Apache-2.0
#include "server/app/survey/drive_cache.h"

#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/support/status_assertions.h"

namespace enfilade::server {
namespace {

absl::Status AddOne(CachedDrive& drive) {
  drive.records += "1";
  return absl::OkStatus();
}

std::string RecordsOf(DriveCache& cache, const std::string& id) {
  std::string records;
  EXPECT_OK(cache.Get(id, [&](CachedDrive& drive) {
    records = drive.records;
    return absl::OkStatus();
  }));
  return records;
}

TEST(DriveCache, KeepsDrivesUntilASurveyDoesNotAskForThem) {
  DriveCache cache;
  ASSERT_OK(cache.Get("a", AddOne));
  ASSERT_OK(cache.Get("a", AddOne));
  ASSERT_OK(cache.Get("b", AddOne));
  EXPECT_EQ(RecordsOf(cache, "a"), "11");
  cache.DropUnused();
  EXPECT_EQ(RecordsOf(cache, "a"), "11");
  cache.DropUnused();
  EXPECT_EQ(RecordsOf(cache, "b"), "");
  EXPECT_EQ(RecordsOf(cache, "a"), "11");
}

TEST(DriveCache, GivesAMappedDriveBackAsItWas) {
  slam::ChainedMap mapped;
  mapped.grid.geometry = {.resolution = 0.1, .T_map_grid = {1.0, 2.0, 0.5}, .width = 200, .height = 100};
  mapped.grid.cells.assign(mapped.grid.geometry.cell_count(), grid::kUnknownCell);
  for (std::size_t i = 0; i < mapped.grid.cells.size(); i += 37) mapped.grid.cells[i] = static_cast<std::uint8_t>(i);
  mapped.trajectory = {{.time = 5, .T_map_robot = {1.0, 2.0, 3.0}}};
  mapped.variance_factor = 2.5;
  DriveCache cache;
  const auto got = cache.Get("a", [&](CachedDrive& drive) {
    drive.mapped = PackedDrive(mapped);
    return absl::OkStatus();
  });
  ASSERT_OK(got);
  EXPECT_EQ(got->grid, mapped.grid);
  ASSERT_EQ(got->trajectory.size(), 1U);
  EXPECT_EQ(got->trajectory[0].T_map_robot, mapped.trajectory[0].T_map_robot);
  EXPECT_EQ(got->variance_factor, mapped.variance_factor);
  EXPECT_LT(cache.bytes(), mapped.grid.cells.size() / 3);
}

TEST(DriveCache, ReportsThatADriveCouldNotBeMapped) {
  DriveCache cache;
  ASSERT_OK(cache.Get("a", AddOne));
  EXPECT_CODE(cache.Get("a", [](CachedDrive&) { return absl::AbortedError("stop"); }), absl::StatusCode::kAborted);
  EXPECT_EQ(RecordsOf(cache, "a"), "1");
}

}  // namespace
}  // namespace enfilade::server
