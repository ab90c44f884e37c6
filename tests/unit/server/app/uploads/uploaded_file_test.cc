// SPDX-License-Identifier: Apache-2.0
#include "server/app/uploads/uploaded_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <utility>

#include "server/app/runtime/retry_hint.h"
#include "tests/support/status_assertions.h"
#include "tests/support/test_data.h"

namespace enfilade::server {
namespace {

using ::testing::HasSubstr;

constexpr std::int64_t kMiB = 1 << 20;

// Content that differs from place to place.
std::string UploadedBytes(std::int64_t size) {
  std::string bytes(static_cast<std::size_t>(size), '.');
  for (std::size_t i = 0; i < bytes.size(); i += 1000) bytes[i] = static_cast<char>('a' + i / 1000 % 26);
  return bytes;
}

class UploadedFileTest : public ::testing::Test {
 protected:
  void ExpectUse(std::int64_t memory, std::int64_t disk) {
    EXPECT_EQ(space_.use().memory_bytes, memory);
    EXPECT_EQ(space_.use().disk_bytes, disk);
  }

  testing::TemporaryDirectory directory_;
  UploadSpace space_{{.directory = directory_.path().string(), .memory_bytes = 2 * kMiB, .disk_bytes = 5 * kMiB}};
};

TEST_F(UploadedFileTest, IsInMemoryWhileSmallThenOnDisk) {
  UploadedFile file(space_);
  ASSERT_OK(file.Append(UploadedBytes(kMiB - 10)));
  ExpectUse(kMiB - 10, 0);
  ASSERT_OK(file.Append(UploadedBytes(10)));
  ExpectUse(kMiB, 0);
  ASSERT_OK(file.Append("x"));
  ExpectUse(0, kMiB + 1);
  ASSERT_OK(file.Append(UploadedBytes(kMiB)));
  EXPECT_EQ(file.size(), 2 * kMiB + 1);
  EXPECT_TRUE(std::filesystem::is_empty(directory_.path())) << "nobody else sees the file";
  ASSERT_OK_AND_ASSIGN(const std::string bytes, file.Take());
  EXPECT_EQ(bytes, UploadedBytes(kMiB - 10) + UploadedBytes(10) + "x" + UploadedBytes(kMiB));
  ExpectUse(0, 0);
  EXPECT_EQ(file.size(), 0);
}

TEST_F(UploadedFileTest, IsOnDiskFromTheStartIfMemoryIsFull) {
  UploadedFile first(space_);
  UploadedFile second(space_);
  ASSERT_OK(first.Append(UploadedBytes(kMiB)));
  ASSERT_OK(second.Append(UploadedBytes(kMiB)));
  UploadedFile third(space_);
  ASSERT_OK(third.Append("abc"));
  ExpectUse(2 * kMiB, 3);
  ASSERT_OK_AND_ASSIGN(const std::string bytes, third.Take());
  EXPECT_EQ(bytes, "abc");
}

TEST_F(UploadedFileTest, IsRefusedForAWhileIfThereIsNoSpace) {
  {
    UploadedFile large(space_);
    for (int i = 0; i < 5; ++i) ASSERT_OK(large.Append(UploadedBytes(kMiB)));
    const absl::Status refused = large.Append("x");
    EXPECT_STATUS(refused, absl::StatusCode::kResourceExhausted, HasSubstr("upload_disk_bytes"));
    EXPECT_TRUE(RetryHintOf(refused));
    ExpectUse(0, 5 * kMiB);
    UploadedFile small(space_);
    EXPECT_OK(small.Append("in memory there is some"));
  }
  ExpectUse(0, 0);
  UploadedFile next(space_);
  for (int i = 0; i < 5; ++i) ASSERT_OK(next.Append(UploadedBytes(kMiB)));
}

TEST_F(UploadedFileTest, CountsOnceWhenItMoves) {
  UploadedFile file(space_);
  ASSERT_OK(file.Append(UploadedBytes(2 * kMiB)));
  UploadedFile moved(std::move(file));
  ExpectUse(0, 2 * kMiB);
  UploadedFile replaced(space_);
  ASSERT_OK(replaced.Append("abc"));
  replaced = std::move(moved);
  ExpectUse(0, 2 * kMiB);
  ASSERT_OK_AND_ASSIGN(const std::string bytes, replaced.Take());
  EXPECT_EQ(bytes, UploadedBytes(2 * kMiB));
  ExpectUse(0, 0);
}

TEST_F(UploadedFileTest, AFolderThatIsNotThereIsNamed) {
  UploadSpace nowhere({.directory = "/nowhere/at/all", .memory_bytes = 0, .disk_bytes = kMiB});
  UploadedFile file(nowhere);
  EXPECT_STATUS(file.Append("x"), absl::StatusCode::kUnavailable, HasSubstr("/nowhere/at/all"));
}

}  // namespace
}  // namespace enfilade::server
