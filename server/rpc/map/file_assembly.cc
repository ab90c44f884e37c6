// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/map/file_assembly.h"

#include <utility>

#include "core/base/error.h"
#include "core/base/sha256.h"

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
    entries_.push_back(entry);
    files_.push_back({entry.name(), {}});
  }
  return absl::OkStatus();
}

absl::Status FileAssembly::Add(const v1::FileChunk& chunk) {
  while (current_ < files_.size() &&
         static_cast<std::int64_t>(files_[current_].bytes.size()) == entries_[current_].size_bytes()) {
    ++current_;
  }
  if (current_ == files_.size()) return InvalidArgument("chunk: all files of the manifest are already complete");
  std::string& bytes = files_[current_].bytes;
  const auto missing = static_cast<std::size_t>(entries_[current_].size_bytes()) - bytes.size();
  if (chunk.file() != static_cast<std::int32_t>(current_) ||
      chunk.offset() != static_cast<std::int64_t>(bytes.size()) || chunk.data().empty() ||
      chunk.data().size() > kMaxFileChunkBytes || chunk.data().size() > missing) {
    return InvalidArgument(
        "chunk (file {}, offset {}, {} bytes) does not follow: expected file {}, offset {} and 1 to {} bytes",
        chunk.file(), chunk.offset(), chunk.data().size(), current_, bytes.size(),
        std::min(kMaxFileChunkBytes, missing));
  }
  bytes += chunk.data();
  return absl::OkStatus();
}

absl::StatusOr<std::vector<grid::MapFile>> FileAssembly::Finish() {
  if (files_.empty()) return InvalidArgument("the first message must be the manifest");
  for (std::size_t i = 0; i < files_.size(); ++i) {
    if (static_cast<std::int64_t>(files_[i].bytes.size()) != entries_[i].size_bytes()) {
      return InvalidArgument("file \"{}\" ends after {} of {} bytes", entries_[i].name(), files_[i].bytes.size(),
                             entries_[i].size_bytes());
    }
    if (Sha256(files_[i].bytes) != entries_[i].sha256()) {
      return DataLoss("file \"{}\" does not have the SHA-256 of the manifest: send it again", entries_[i].name());
    }
  }
  return std::exchange(files_, {});
}

}  // namespace enfilade::server
