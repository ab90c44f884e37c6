// SPDX-License-Identifier: Apache-2.0
#include "client/sdk/api/file_download.h"

#include "core/base/error.h"

namespace enfilade::client {

DownloadCheck::DownloadCheck(const google::protobuf::RepeatedPtrField<v1::FileEntry>& files) : files_(files.size()) {
  for (int i = 0; i < files.size(); ++i) {
    files_[static_cast<std::size_t>(i)].entry = files.Get(i);
    total_ += files.Get(i).size_bytes();
  }
}

absl::Status DownloadCheck::Add(const v1::FileChunk& chunk) {
  if (chunk.file() < 0 || chunk.file() >= static_cast<int>(files_.size())) {
    return DataLoss("the server sent a chunk of file {}, but the manifest has {} files", chunk.file(), files_.size());
  }
  File& file = files_[static_cast<std::size_t>(chunk.file())];
  if (chunk.offset() != file.size) {
    return DataLoss("{}: the server sent offset {} after {} bytes", file.entry.name(), chunk.offset(), file.size);
  }
  const auto size = static_cast<std::int64_t>(chunk.data().size());
  file.size += size;
  received_ += size;
  file.hash.Add(chunk.data());
  return absl::OkStatus();
}

absl::Status DownloadCheck::Finish() {
  for (File& file : files_) {
    if (file.size != file.entry.size_bytes()) {
      return DataLoss("{}: {} of {} bytes arrived: try again", file.entry.name(), file.size, file.entry.size_bytes());
    }
    if (file.hash.Finish() != file.entry.sha256()) {
      return DataLoss("{} was damaged in transit (its SHA-256 differs): try again", file.entry.name());
    }
  }
  return absl::OkStatus();
}

}  // namespace enfilade::client
