// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "core/base/sha256.h"
#include "core/grid/files/map_files.h"
#include "enfilade/v1/transfer.pb.h"
#include "google/protobuf/repeated_ptr_field.h"
#include "server/app/uploads/uploaded_file.h"

namespace enfilade::server {

// Assembles the files of an upload from their chunks, in an UploadSpace.
class FileAssembly {
 public:
  explicit FileAssembly(UploadSpace& space) : space_(&space) {}

  // INVALID_ARGUMENT: no files, too many, sizes out of range or above `max_bytes` in total, a digest of the wrong
  // length.
  absl::Status Begin(const google::protobuf::RepeatedPtrField<v1::FileEntry>& entries, std::int64_t max_bytes);
  // INVALID_ARGUMENT if the chunk is not the next one. Errors as UploadedFile::Append.
  absl::Status Add(const v1::FileChunk& chunk);
  // The files, in memory. INVALID_ARGUMENT if one is incomplete, DATA_LOSS if it does not have its digest. Errors as
  // UploadedFile::Take.
  absl::StatusOr<std::vector<grid::MapFile>> Finish();

 private:
  struct File {
    v1::FileEntry entry;
    UploadedFile bytes;
    Sha256Stream digest = {};

    bool is_complete() const { return bytes.size() == entry.size_bytes(); }
  };

  UploadSpace* space_;
  std::vector<File> files_;
  std::size_t current_ = 0;
};

}  // namespace enfilade::server
