// SPDX-License-Identifier: Apache-2.0
#include "client/sources/line_source.h"

#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace enfilade::sources {
namespace {

namespace fs = std::filesystem;

constexpr unsigned kReadBytes = 256U << 10;

bool IsBinary(char c) { return static_cast<unsigned char>(c) < 0x20 && c != '\t' && c != '\r' && c != '\f'; }

}  // namespace

void LineSource::CloseGz::operator()(void* file) const { gzclose_r(static_cast<gzFile>(file)); }

LineSource::LineSource(fs::path path, void* file) : path_(std::move(path)), file_(file) {}

absl::StatusOr<LineSource> LineSource::Open(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (status.type() == fs::file_type::not_found) return NotFound("{}: no such file", path.string());
  if (status.type() == fs::file_type::directory) {
    return InvalidArgument("{}: is a directory: name the log file in it", path.string());
  }
  errno = 0;
  gzFile file = gzopen(path.c_str(), "rb");
  if (!file) {
    const int reason = errno == 0 ? ENOMEM : errno;
    return absl::ErrnoToStatus(reason, path.string() + ": cannot be opened");
  }
  gzbuffer(file, kReadBytes);
  return LineSource(path, file);
}

absl::Status LineSource::Fill() {
  buffer_.erase(0, begin_);
  begin_ = 0;
  const std::size_t old_size = buffer_.size();
  buffer_.resize(old_size + kReadBytes);
  auto* file = static_cast<gzFile>(file_.get());
  const int got = gzread(file, buffer_.data() + old_size, kReadBytes);
  buffer_.resize(old_size + static_cast<std::size_t>(std::max(got, 0)));
  int code = Z_OK;
  const char* message = gzerror(file, &code);
  if (got < 0 || code == Z_BUF_ERROR) {
    at_end_ = true;
    buffer_.clear();
    const std::string reason = code == Z_ERRNO ? std::strerror(errno) : message;
    return InvalidArgument("{}:{}: the compressed data is damaged or cut off ({})", path_.string(), line_number_ + 1,
                           reason);
  }
  at_end_ = got == 0;
  return absl::OkStatus();
}

absl::StatusOr<std::optional<std::string_view>> LineSource::Next() {
  std::size_t searched = begin_;
  std::size_t end = buffer_.find('\n', searched);
  while (end == std::string::npos && !at_end_) {
    if (buffer_.size() - begin_ > kMaxLineBytes) {
      at_end_ = true;
      buffer_.clear();
      begin_ = 0;
      return InvalidArgument("{}:{}: the line is longer than {} MiB", path_.string(), line_number_ + 1,
                             kMaxLineBytes >> 20);
    }
    searched = buffer_.size() - begin_;
    ENFILADE_RETURN_IF_ERROR(Fill());
    end = buffer_.find('\n', searched);
  }
  if (end == std::string::npos && begin_ == buffer_.size()) return std::nullopt;
  std::string_view line = std::string_view(buffer_).substr(begin_, end == std::string::npos ? end : end - begin_);
  begin_ = end == std::string::npos ? buffer_.size() : end + 1;
  ++line_number_;
  if (line.ends_with('\r')) line.remove_suffix(1);
  if (const auto bad = std::find_if(line.begin(), line.end(), IsBinary); bad != line.end()) {
    return InvalidArgument("{}: binary data (byte 0x{:02x} at column {}): not a text log", Where(),
                           static_cast<unsigned char>(*bad), bad - line.begin() + 1);
  }
  return line;
}

std::string LineSource::Where() const { return fmt::format("{}:{}", path_.string(), line_number_); }

}  // namespace enfilade::sources
