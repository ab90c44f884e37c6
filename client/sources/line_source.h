// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace enfilade::sources {

// The lines of a text file, plain or gzip-compressed (told by content, not by name). Not thread-safe.
class LineSource {
 public:
  // NOT_FOUND where there is no such file, INVALID_ARGUMENT for a directory, PERMISSION_DENIED or UNKNOWN otherwise.
  static absl::StatusOr<LineSource> Open(const std::filesystem::path& path);

  // The next line without its end ("\n" or "\r\n"), nullopt at the end of the file. The view holds until the next
  // call. INVALID_ARGUMENT "file:line: ..." on binary content, a line over kMaxLineBytes, damaged or truncated
  // compressed data; nothing more can be read then, except after binary content, which spoils its line only.
  absl::StatusOr<std::optional<std::string_view>> Next();

  const std::filesystem::path& path() const { return path_; }
  // Of the line that Next gave last, counted from 1.
  std::int64_t line_number() const { return line_number_; }
  // "file:line", for messages.
  std::string Where() const;

  static constexpr std::size_t kMaxLineBytes = 64U << 20;

 private:
  struct CloseGz {
    void operator()(void* file) const;
  };

  LineSource(std::filesystem::path path, void* file);
  absl::Status Fill();

  std::filesystem::path path_;
  std::unique_ptr<void, CloseGz> file_;  // gzFile
  std::string buffer_;                   // read, not yet given; the line given last lies before begin_
  std::size_t begin_ = 0;
  bool at_end_ = false;
  std::int64_t line_number_ = 0;
};

}  // namespace enfilade::sources
