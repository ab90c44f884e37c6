// SPDX-License-Identifier: Apache-2.0
#include "client/sources/line_source.h"

#include <gtest/gtest.h>

#include "client/sources/content.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/client/sources/log_files.h"

namespace enfilade::sources {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::LogFiles;

// All lines up to the end or the first error.
std::vector<std::string> LinesOf(LineSource& source, absl::Status& status) {
  std::vector<std::string> lines;
  while (true) {
    const absl::StatusOr<std::optional<std::string_view>> line = source.Next();
    status = line.status();
    if (!line.ok() || !line->has_value()) return lines;
    lines.emplace_back(**line);
  }
}

TEST(LineSource, GivesLinesWithoutTheirEnds) {
  const LogFiles files;
  absl::Status status;
  ASSERT_OK_AND_ASSIGN(LineSource source, LineSource::Open(files.Write("a", "one\n\ntwo\r\n three\tend \nlast")));
  EXPECT_THAT(LinesOf(source, status), ElementsAre("one", "", "two", " three\tend ", "last"));
  EXPECT_OK(status);
  EXPECT_EQ(source.line_number(), 5);
  EXPECT_THAT(source.Where(), ::testing::EndsWith("a:5"));
  ASSERT_OK_AND_ASSIGN(const auto end, source.Next());
  EXPECT_FALSE(end.has_value()) << "the end stays the end";
}

TEST(LineSource, AnEmptyFileHasNoLines) {
  const LogFiles files;
  for (const char* text : {"", "\n"}) {
    absl::Status status;
    ASSERT_OK_AND_ASSIGN(LineSource source, LineSource::Open(files.Write("a", text)));
    EXPECT_EQ(LinesOf(source, status).size(), std::string(text).size());
    EXPECT_OK(status);
  }
}

TEST(LineSource, KeepsLinesTogetherThatSpanItsReads) {
  const LogFiles files;
  std::string text;
  std::vector<std::string> expected;
  for (int i = 0; i < 200; ++i) {
    expected.emplace_back(static_cast<std::size_t>(i * 61 % 9000), static_cast<char>('a' + i % 26));
    text += expected.back() + "\n";
  }
  for (const auto& path : {files.Write("plain", text), files.WriteGz("packed", text)}) {
    absl::Status status;
    ASSERT_OK_AND_ASSIGN(LineSource source, LineSource::Open(path));
    EXPECT_EQ(LinesOf(source, status), expected) << path;
    EXPECT_OK(status);
  }
}

TEST(LineSource, ContinuesAfterBinaryContent) {
  const LogFiles files;
  ASSERT_OK_AND_ASSIGN(LineSource source, LineSource::Open(files.Write("a", std::string("good\nb\0d\nagain\n", 15))));
  EXPECT_OK(source.Next());
  EXPECT_STATUS(source.Next(), absl::StatusCode::kInvalidArgument,
                HasSubstr("a:2: binary data (byte 0x00 at column 2)"));
  ASSERT_OK_AND_ASSIGN(const auto line, source.Next());
  EXPECT_EQ(line, "again");
}

TEST(LineSource, RefusesALineWithoutEnd) {
  const LogFiles files;
  std::string text = "first\n";
  text.append(LineSource::kMaxLineBytes + (1U << 20), 'x');
  // Packed, so that the test writes little.
  ASSERT_OK_AND_ASSIGN(LineSource source, LineSource::Open(files.WriteGz("a", text)));
  EXPECT_OK(source.Next());
  EXPECT_STATUS(source.Next(), absl::StatusCode::kInvalidArgument, HasSubstr("a:2: the line is longer than 64 MiB"));
  ASSERT_OK_AND_ASSIGN(const auto end, source.Next());
  EXPECT_FALSE(end.has_value()) << "nothing more can be read";
}

TEST(LineSource, NamesFilesThatCannotBeOpened) {
  const LogFiles files;
  EXPECT_STATUS(LineSource::Open(files.path() / "none"), absl::StatusCode::kNotFound, HasSubstr("no such file"));
  EXPECT_STATUS(LineSource::Open(files.path()), absl::StatusCode::kInvalidArgument, HasSubstr("is a directory"));
  EXPECT_CODE(LineSource::Open(files.Write("file", "x") / "inside"), absl::StatusCode::kNotFound);
}

TEST(ReadContent, GivesWholeFilesWithinTheLimits) {
  const LogFiles files;
  const std::string bytes("\0\x01\xff binary", 10);
  ASSERT_OK_AND_ASSIGN(const std::string content, ReadContent(files.Write("a", bytes)));
  EXPECT_EQ(content, bytes);
  EXPECT_EQ(RefOf(content).size, 10);
  EXPECT_NE(RefOf(content), RefOf("other"));
  EXPECT_STATUS(ReadContent(files.path() / "none"), absl::StatusCode::kNotFound, HasSubstr("none"));
  EXPECT_CODE(ReadContent(files.path()), absl::StatusCode::kInvalidArgument);
  EXPECT_STATUS(ReadContent(files.Write("empty", "")), absl::StatusCode::kInvalidArgument, HasSubstr("0 bytes"));
  const auto large = files.Write("large", "x");
  std::filesystem::resize_file(large, sensor::kMaxBlobBytes + 1);  // sparse
  EXPECT_STATUS(ReadContent(large), absl::StatusCode::kInvalidArgument, HasSubstr("expected 1 to"));
}

}  // namespace
}  // namespace enfilade::sources
