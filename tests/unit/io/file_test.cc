// SPDX-License-Identifier: Apache-2.0
#include "io/file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <string>
#include <thread>

#include "tests/support/status_assertions.h"
#include "tests/support/test_data.h"

namespace enfilade::io {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class FileTest : public ::testing::Test {
 protected:
  fs::path File(const std::string& name) const { return directory_.path() / name; }

  enfilade::testing::TemporaryDirectory directory_;
};

std::string Bytes(std::size_t size) {
  std::string bytes(size, '\0');
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<char>(i * 131 + i / 251);
  return bytes;
}

TEST_F(FileTest, ReadsWhatWasWrittenAtEverySizeAroundItsBuffer) {
  for (const std::size_t size : {0U, 1U, 2U, 65535U, 65536U, 65537U, 131072U, 131073U, 3'000'001U}) {
    const std::string bytes = Bytes(size);
    ASSERT_OK(WriteFile(File("a"), bytes));
    EXPECT_EQ(fs::file_size(File("a")), size);
    ASSERT_OK_AND_ASSIGN(const std::string read, ReadFile(File("a")));
    EXPECT_TRUE(read == bytes) << size;  // without 3 MB of difference
  }
}

TEST_F(FileTest, WritingReplacesALongerFile) {
  ASSERT_OK(WriteFile(File("a"), Bytes(1000)));
  ASSERT_OK(WriteFile(File("a"), "short"));
  ASSERT_OK_AND_ASSIGN(const std::string read, ReadFile(File("a")));
  EXPECT_EQ(read, "short");
}

TEST_F(FileTest, ReadsWhatHasNoSizeToItsEnd) {
  ASSERT_OK_AND_ASSIGN(const std::string status, ReadFile("/proc/self/status"));
  EXPECT_THAT(status, HasSubstr("Pid:\t" + std::to_string(getpid()) + "\n"));
  EXPECT_EQ(status.back(), '\n');

  const fs::path pipe = File("pipe");
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const std::string bytes = Bytes(300'000);
  absl::Status written;
  std::thread writer([&] { written = WriteFile(pipe, bytes); });
  const absl::StatusOr<std::string> read = ReadFile(pipe);
  writer.join();
  EXPECT_OK(written);
  ASSERT_OK(read);
  EXPECT_TRUE(*read == bytes);
}

TEST_F(FileTest, FollowsLinks) {
  ASSERT_OK(WriteFile(File("a"), "old"));
  fs::create_symlink("a", File("link"));
  ASSERT_OK(WriteFile(File("link"), "new"));
  ASSERT_OK_AND_ASSIGN(const std::string read, ReadFile(File("a")));
  EXPECT_EQ(read, "new");
  fs::create_symlink("nowhere", File("dangling"));
  EXPECT_CODE(ReadFile(File("dangling")), absl::StatusCode::kNotFound);
}

TEST_F(FileTest, MissingFilesAndFoldersHaveCodesOfTheirOwn) {
  EXPECT_STATUS(ReadFile(File("none")), absl::StatusCode::kNotFound, StartsWith(File("none").string() + ": "));
  EXPECT_STATUS(ReadFile(File("")), absl::StatusCode::kInvalidArgument, HasSubstr("is a folder"));
  EXPECT_STATUS(ReadFile(""), absl::StatusCode::kNotFound, HasSubstr("no such file"));
  EXPECT_STATUS(WriteFile(File("none") / "a", "x"), absl::StatusCode::kFailedPrecondition,
                HasSubstr("folder does not exist"));
  EXPECT_STATUS(WriteFile(directory_.path(), "x"), absl::StatusCode::kInvalidArgument, HasSubstr("is a folder"));
  ASSERT_OK(WriteFile(File("a"), "x"));
  EXPECT_CODE(ReadFile(File("a") / "b"), absl::StatusCode::kNotFound);
  EXPECT_CODE(WriteFile(File("a") / "b", "x"), absl::StatusCode::kFailedPrecondition);
}

TEST_F(FileTest, AFullDiskIsNamed) {
  EXPECT_STATUS(WriteFile("/dev/full", "x"), absl::StatusCode::kResourceExhausted, HasSubstr("/dev/full"));
  EXPECT_OK(WriteFile("/dev/full", ""));
}

TEST_F(FileTest, MissingPermissionIsNamed) {
  if (geteuid() == 0) GTEST_SKIP() << "root may read and write everything";
  ASSERT_OK(WriteFile(File("a"), "x"));
  fs::permissions(File("a"), fs::perms::none);
  EXPECT_STATUS(ReadFile(File("a")), absl::StatusCode::kPermissionDenied, HasSubstr("cannot be read"));
  EXPECT_STATUS(WriteFile(File("a"), "y"), absl::StatusCode::kPermissionDenied, HasSubstr("cannot be written"));
}

TEST_F(FileTest, MapsTheErrorsOfTheSystem) {
  const auto code = [](int error) { return FileError("/a/b", "cannot be opened", error).code(); };
  for (const int error : {EACCES, EPERM, EROFS}) EXPECT_EQ(code(error), absl::StatusCode::kPermissionDenied) << error;
  for (const int error : {ENOSPC, EDQUOT}) EXPECT_EQ(code(error), absl::StatusCode::kResourceExhausted) << error;
  for (const int error : {EIO, EMFILE, ELOOP}) EXPECT_EQ(code(error), absl::StatusCode::kInternal) << error;
  EXPECT_EQ(FileError("/a/b", "cannot be opened", EIO).message(), "/a/b: cannot be opened: Input/output error");
}

}  // namespace
}  // namespace enfilade::io
