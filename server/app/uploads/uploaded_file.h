// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/app/uploads/upload_space.h"

namespace enfilade::server {

// The bytes of one upload as they come: in memory while they are few, then in a file without a name, which goes with
// its owner or its process. All of them count in an UploadSpace, which must outlive it. Not thread-safe.
class UploadedFile {
 public:
  // Up to so many bytes stay in memory.
  static constexpr std::int64_t kMaxInMemory = 1 << 20;

  explicit UploadedFile(UploadSpace& space) : space_(&space) {}
  ~UploadedFile() { Release(); }
  UploadedFile(UploadedFile&& other) noexcept;
  UploadedFile& operator=(UploadedFile&& other) noexcept;

  std::int64_t size() const { return size_; }

  // Does not wait for the disk: the file is not synchronised. RESOURCE_EXHAUSTED if uploads under way fill their space,
  // or the disk is full: the caller ends the upload.
  absl::Status Append(std::string_view bytes);

  // All bytes, in memory: whoever calls it bounds how much is read at the same time. The file is empty afterwards.
  // UNAVAILABLE if it cannot be read.
  absl::StatusOr<std::string> Take();

 private:
  bool is_on_disk() const { return descriptor_ >= 0; }
  absl::Status MoveToDisk();
  absl::Status Write(std::string_view bytes);
  void Release();

  UploadSpace* space_;
  std::int64_t size_ = 0;
  std::string memory_;   // all of it, unless it is on disk
  int descriptor_ = -1;  // of the file; -1: in memory
};

}  // namespace enfilade::server
