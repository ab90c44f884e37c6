// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "core/grid/files/map_files.h"
#include "enfilade/v1/transfer.pb.h"
#include "google/protobuf/repeated_ptr_field.h"

namespace enfilade::server {

// Puts the files of an upload together from their chunks.
class FileAssembly {
 public:
  // INVALID_ARGUMENT: no files, more than a few, sizes out of range or above `max_bytes` together, a digest of the
  // wrong length.
  absl::Status Begin(const google::protobuf::RepeatedPtrField<v1::FileEntry>& entries, std::int64_t max_bytes);
  // INVALID_ARGUMENT where the chunk is not the next one.
  absl::Status Add(const v1::FileChunk& chunk);
  // The files. INVALID_ARGUMENT where one is not complete, DATA_LOSS where its digest is another.
  absl::StatusOr<std::vector<grid::MapFile>> Finish();

 private:
  std::vector<v1::FileEntry> entries_;
  std::vector<grid::MapFile> files_;
  std::size_t current_ = 0;
};

}  // namespace enfilade::server
