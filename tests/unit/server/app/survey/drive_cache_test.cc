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

TEST(DriveCache, ReportsThatADriveCouldNotBeMapped) {
  DriveCache cache;
  ASSERT_OK(cache.Get("a", AddOne));
  EXPECT_CODE(cache.Get("a", [](CachedDrive&) { return absl::AbortedError("stop"); }), absl::StatusCode::kAborted);
  EXPECT_EQ(RecordsOf(cache, "a"), "1");
}

}  // namespace
}  // namespace enfilade::server
