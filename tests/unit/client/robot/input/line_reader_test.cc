// SPDX-License-Identifier: Apache-2.0
#include "client/robot/input/line_reader.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <string>
#include <thread>
#include <vector>

#include "tests/support/status_assertions.h"

namespace enfilade::robot {
namespace {

constexpr auto kNoWait = std::chrono::milliseconds(0);
// Returns as soon as a line is there: only a failing test waits so long.
constexpr auto kLong = std::chrono::minutes(2);

class LineReaderTest : public ::testing::Test {
 protected:
  LineReaderTest() {
    int ends[2];
    EXPECT_EQ(pipe(ends), 0);
    read_ = ends[0];
    write_ = ends[1];
    reader_.emplace(read_);
  }
  ~LineReaderTest() override {
    CloseInput();
    close(read_);
  }
  void Put(const std::string& text) const {
    for (std::size_t at = 0; at < text.size();) {
      const ssize_t count = write(write_, text.data() + at, text.size() - at);
      ASSERT_GT(count, 0);
      at += static_cast<std::size_t>(count);
    }
  }
  void CloseInput() {
    if (write_ >= 0) close(write_);
    write_ = -1;
  }
  std::optional<std::string> Next(std::chrono::milliseconds timeout = kLong) {
    absl::StatusOr<std::optional<std::string>> line = reader_->Next(timeout);
    EXPECT_OK(line);
    return line.ok() ? *line : std::nullopt;
  }

  int read_ = -1;
  int write_ = -1;
  std::optional<LineReader> reader_;
};

TEST_F(LineReaderTest, GivesLinesWithoutTheirEnds) {
  Put("one\ntwo\r\n\nfour");
  EXPECT_EQ(Next(), "one");
  EXPECT_EQ(Next(), "two");
  EXPECT_EQ(Next(), "");
  EXPECT_EQ(reader_->line_number(), 3);
  EXPECT_EQ(Next(kNoWait), std::nullopt) << "the last line may still grow";
  EXPECT_FALSE(reader_->at_end());
  CloseInput();
  EXPECT_EQ(Next(), "four");
  EXPECT_EQ(reader_->line_number(), 4);
  EXPECT_EQ(Next(), std::nullopt);
  EXPECT_TRUE(reader_->at_end());
}

TEST_F(LineReaderTest, AnEmptyInputEndsAtOnce) {
  EXPECT_EQ(Next(kNoWait), std::nullopt);
  EXPECT_FALSE(reader_->at_end());
  CloseInput();
  EXPECT_EQ(Next(), std::nullopt);
  EXPECT_TRUE(reader_->at_end());
  EXPECT_EQ(reader_->line_number(), 0);
}

TEST_F(LineReaderTest, JoinsALineThatComesInPieces) {
  for (const char* piece : {"a", "bc", "", "def"}) {
    Put(piece);
    EXPECT_EQ(Next(kNoWait), std::nullopt);
  }
  Put("g\nnext\n");
  EXPECT_EQ(Next(), "abcdefg");
  EXPECT_EQ(Next(), "next");
}

TEST_F(LineReaderTest, WakesUpWhenALineComes) {
  std::thread writer([this] { Put("late\n"); });
  EXPECT_EQ(Next(), "late");
  writer.join();
}

TEST_F(LineReaderTest, GivesManyLinesOfOneWriteInOrder) {
  std::string text;
  for (int i = 0; i < 5000; ++i) text += std::to_string(i) + "\n";
  std::thread writer([&] {
    Put(text);
    CloseInput();
  });
  for (int i = 0; i < 5000; ++i) ASSERT_EQ(Next(), std::to_string(i));
  writer.join();
  EXPECT_EQ(Next(), std::nullopt);
  EXPECT_TRUE(reader_->at_end());
}

TEST_F(LineReaderTest, SkipsALineThatIsTooLong) {
  std::thread writer([this] {
    Put("short\n");
    const std::string piece(1 << 20, 'x');
    for (int i = 0; i < 66; ++i) Put(piece);
    Put("\nafter\n");
    CloseInput();
  });
  EXPECT_EQ(Next(), "short");
  absl::StatusOr<std::optional<std::string>> line = reader_->Next(kLong);
  EXPECT_STATUS(line, absl::StatusCode::kInvalidArgument, ::testing::HasSubstr("line 2 is longer than 64 MiB"));
  EXPECT_EQ(Next(), "after");
  EXPECT_EQ(reader_->line_number(), 3);
  writer.join();
  EXPECT_EQ(Next(), std::nullopt);
}

TEST_F(LineReaderTest, AnUnreadableInputIsAnError) {
  const int folder = open("/", O_RDONLY);
  LineReader closed(folder);
  EXPECT_CODE(closed.Next(kLong), absl::StatusCode::kUnknown);
  close(folder);
}

}  // namespace
}  // namespace enfilade::robot
