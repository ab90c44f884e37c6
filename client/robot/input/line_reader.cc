// SPDX-License-Identifier: Apache-2.0
#include "client/robot/input/line_reader.h"

#include <poll.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "core/base/error.h"

namespace enfilade::robot {
namespace {

constexpr std::size_t kMaxLineBytes = 64U << 20;

}  // namespace

std::optional<std::string> LineReader::TakeLine() {
  const std::size_t end = buffer_.find('\n', searched_);
  if (end == std::string::npos && !(at_end_ && begin_ < buffer_.size())) {
    searched_ = buffer_.size();
    return std::nullopt;
  }
  std::string line = buffer_.substr(begin_, end == std::string::npos ? end : end - begin_);
  begin_ = searched_ = end == std::string::npos ? buffer_.size() : end + 1;
  if (!line.empty() && line.back() == '\r') line.pop_back();
  ++line_number_;
  return line;
}

absl::StatusOr<std::optional<std::string>> LineReader::Next(std::chrono::milliseconds timeout) {
  while (true) {
    if (std::optional<std::string> line = TakeLine()) {
      if (!skipping_) return line;
      skipping_ = false;
      continue;
    }
    if (at_end_) return std::nullopt;
    buffer_.erase(0, begin_);
    begin_ = 0;
    searched_ = buffer_.size();
    if (buffer_.size() > kMaxLineBytes) {
      buffer_.clear();
      searched_ = 0;
      if (!std::exchange(skipping_, true)) {
        return InvalidArgument("line {} is longer than 64 MiB", line_number_ + 1);
      }
    }
    pollfd ready{fd_, POLLIN, 0};
    const int polled = poll(&ready, 1, static_cast<int>(timeout.count()));
    if (polled == 0 || (polled < 0 && errno == EINTR)) return std::nullopt;
    std::array<char, 65536> bytes;
    const ssize_t count = read(fd_, bytes.data(), bytes.size());
    if (count < 0 && errno != EINTR && errno != EAGAIN) {
      return absl::UnknownError(fmt::format("the input cannot be read: {}", std::strerror(errno)));
    }
    if (count == 0) at_end_ = true;
    if (count > 0) buffer_.append(bytes.data(), static_cast<std::size_t>(count));
  }
}

}  // namespace enfilade::robot
