// SPDX-License-Identifier: Apache-2.0
#include "client/sdk/api/file_folder.h"

#include <system_error>

#include "core/base/error.h"

namespace enfilade::client {
namespace {

namespace fs = std::filesystem;

fs::path PartialFile(const fs::path& path) { return path.string() + ".part"; }

}  // namespace

absl::Status CreateFolder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return InvalidArgument("{}: the folder cannot be created: {}", folder.string(), error.message());
  return absl::OkStatus();
}

PartFiles::~PartFiles() {
  std::error_code ignored;
  for (const fs::path& path : paths_) fs::remove(PartialFile(path), ignored);
}

void PartFiles::Start(const google::protobuf::RepeatedPtrField<v1::FileEntry>& files) {
  for (const v1::FileEntry& file : files) paths_.push_back(folder_ / fs::path(file.name()).filename());
}

absl::Status PartFiles::Write(const v1::FileChunk& chunk) {
  const fs::path part = PartialFile(paths_[static_cast<std::size_t>(chunk.file())]);
  if (chunk.offset() == 0) {
    out_ = std::ofstream(part, std::ios::binary | std::ios::trunc);
    if (!out_) return InvalidArgument("{}: cannot be written", part.string());
  }
  out_.write(chunk.data().data(), static_cast<std::streamsize>(chunk.data().size()));
  if (out_.flush()) return absl::OkStatus();
  return ResourceExhausted("{}: cannot be written: is the disk full?", folder_.string());
}

absl::StatusOr<std::vector<fs::path>> PartFiles::Commit() {
  out_.close();
  for (const fs::path& path : paths_) {
    std::error_code error;
    if (!fs::exists(PartialFile(path), error))
      std::ofstream(PartialFile(path), std::ios::binary);  // an empty file: no chunks
    fs::rename(PartialFile(path), path, error);
    if (error) return InvalidArgument("{}: cannot be written: {}", path.string(), error.message());
  }
  return paths_;
}

}  // namespace enfilade::client
