// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/map/file_assembly.h"

#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace enfilade::server {
namespace {

constexpr int kMaxFiles = 4;
constexpr std::size_t kMaxFileChunkBytes = 1U << 20;

}  // namespace

absl::Status FileAssembly::Begin(const google::protobuf::RepeatedPtrField<v1::FileEntry>& entries,
                                 std::int64_t max_bytes) {
  if (entries.empty() || entries.size() > kMaxFiles) {
    return InvalidArgument("manifest.files has {} entries: expected 1 to {}", entries.size(), kMaxFiles);
  }
  std::int64_t total = 0;
  for (const v1::FileEntry& entry : entries) {
    if (entry.sha256().size() != 32) {
      return InvalidArgument("manifest: file \"{}\": sha256 has {} bytes: expected 32", entry.name(),
                             entry.sha256().size());
    }
    if (entry.size_bytes() < 1 || entry.size_bytes() > max_bytes - total) {
      return InvalidArgument("manifest: file \"{}\" has {} bytes: expected at least 1 and at most {} for all files",
                             entry.name(), entry.size_bytes(), max_bytes);
    }
    total += entry.size_bytes();
    files_.push_back({entry, UploadedFile(*space_)});
  }
  return absl::OkStatus();
}

absl::Status FileAssembly::Add(const v1::FileChunk& chunk) {
  while (current_ < files_.size() && files_[current_].is_complete()) ++current_;
  if (current_ == files_.size()) return InvalidArgument("chunk: all files of the manifest are already complete");
  File& file = files_[current_];
  const std::int64_t received = file.bytes.size();
  const auto missing = static_cast<std::size_t>(file.entry.size_bytes() - received);
  if (chunk.file() != static_cast<std::int32_t>(current_) || chunk.offset() != received || chunk.data().empty() ||
      chunk.data().size() > kMaxFileChunkBytes || chunk.data().size() > missing) {
    return InvalidArgument(
        "chunk (file {}, offset {}, {} bytes) does not follow: expected file {}, offset {} and 1 to {} bytes",
        chunk.file(), chunk.offset(), chunk.data().size(), current_, received, std::min(kMaxFileChunkBytes, missing));
  }
  file.digest.Add(chunk.data());
  return file.bytes.Append(chunk.data());
}

absl::StatusOr<std::vector<grid::MapFile>> FileAssembly::Finish() {
  if (files_.empty()) return InvalidArgument("the first message must be the manifest");
  for (const File& file : files_) {
    if (file.is_complete()) continue;
    return InvalidArgument("file \"{}\" ends after {} of {} bytes", file.entry.name(), file.bytes.size(),
                           file.entry.size_bytes());
  }
  std::vector<grid::MapFile> whole;
  for (File& file : files_) {
    if (file.digest.Finish() != file.entry.sha256()) {
      return DataLoss("file \"{}\" does not have the SHA-256 of the manifest: send it again", file.entry.name());
    }
    ENFILADE_ASSIGN_OR_RETURN(std::string bytes, file.bytes.Take());
    whole.push_back({file.entry.name(), std::move(bytes)});
  }
  return whole;
}

}  // namespace enfilade::server
