// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "absl/status/statusor.h"

namespace enfilade::robot {

// Reads lines from a file descriptor with a timeout. Not thread-safe.
class LineReader {
 public:
  explicit LineReader(int fd) : fd_(fd) {}

  // The next line without its end; nullopt if none came within `timeout`, or at the end of the input. INVALID_ARGUMENT:
  // a line of more than 64 MiB, which is skipped. UNKNOWN: the input cannot be read.
  absl::StatusOr<std::optional<std::string>> Next(std::chrono::milliseconds timeout);
  // No more lines will come.
  bool at_end() const { return at_end_ && begin_ >= buffer_.size(); }
  // Of the line given last, counted from 1.
  std::int64_t line_number() const { return line_number_; }

 private:
  std::optional<std::string> TakeLine();

  int fd_;
  std::string buffer_;
  std::size_t begin_ = 0;     // of what was not returned yet
  std::size_t searched_ = 0;  // there is no line end before this position
  bool at_end_ = false;
  bool skipping_ = false;  // the rest of a line that is too long
  std::int64_t line_number_ = 0;
};

}  // namespace enfilade::robot
