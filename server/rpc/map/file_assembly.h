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

// Assembles the files of an upload from their chunks.
class FileAssembly {
 public:
  // INVALID_ARGUMENT: no files, too many, sizes out of range or above `max_bytes` in total, a digest of the wrong
  // length.
  absl::Status Begin(const google::protobuf::RepeatedPtrField<v1::FileEntry>& entries, std::int64_t max_bytes);
  // INVALID_ARGUMENT if the chunk is not the next one.
  absl::Status Add(const v1::FileChunk& chunk);
  // The files. INVALID_ARGUMENT if one is incomplete, DATA_LOSS if it does not have its digest.
  absl::StatusOr<std::vector<grid::MapFile>> Finish();

 private:
  std::vector<v1::FileEntry> entries_;
  std::vector<grid::MapFile> files_;
  std::size_t current_ = 0;
};

}  // namespace enfilade::server
