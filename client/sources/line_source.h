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

// The lines of a text file, plain or gzip-compressed (detected by content, not by name). Not thread-safe.
class LineSource {
 public:
  // NOT_FOUND: no such file; INVALID_ARGUMENT: a directory; PERMISSION_DENIED or UNKNOWN otherwise.
  static absl::StatusOr<LineSource> Open(const std::filesystem::path& path);

  // The next line without its end ("\n" or "\r\n"), nullopt at the end of the file. The view is valid until the next
  // call. INVALID_ARGUMENT "file:line: ...": binary content, a line over kMaxLineBytes, damaged or truncated compressed
  // data. After binary content reading can continue with the next line, after the others it cannot.
  absl::StatusOr<std::optional<std::string_view>> Next();

  const std::filesystem::path& path() const { return path_; }
  // Of the line that Next returned last, counted from 1.
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
  std::string buffer_;                   // read, not yet returned; the line returned last lies before begin_
  std::size_t begin_ = 0;
  bool at_end_ = false;
  std::int64_t line_number_ = 0;
};

}  // namespace enfilade::sources
