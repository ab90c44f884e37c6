// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "absl/status/statusor.h"

namespace enfilade::robot {

// Lines of a file descriptor, without waiting longer than one wants to. Not thread-safe.
class LineInput {
 public:
  explicit LineInput(int fd) : fd_(fd) {}

  // The next line without its end; nullopt where none came within `patience`, or at the end. INVALID_ARGUMENT: a line
  // of more than 64 MiB, which is passed over. UNKNOWN: cannot be read.
  absl::StatusOr<std::optional<std::string>> Next(std::chrono::milliseconds patience);
  // Nothing more will come.
  bool at_end() const { return at_end_ && begin_ >= buffer_.size(); }
  std::int64_t line_number() const { return line_number_; }

 private:
  std::optional<std::string> Take();

  int fd_;
  std::string buffer_;
  std::size_t begin_ = 0;     // of what was not given yet
  std::size_t searched_ = 0;  // up to where there is no end of a line
  bool at_end_ = false;
  bool passing_over_ = false;  // of a line that is too long
  std::int64_t line_number_ = 0;
};

}  // namespace enfilade::robot
