// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>

#include "absl/status/statusor.h"

namespace enfilade::client {

// Keeps a file to one process, by flock on "FILE.lock": the system frees it when the process ends, however it ends.
class FileLock {
 public:
  // FAILED_PRECONDITION naming the other process where it is taken.
  static absl::StatusOr<FileLock> Take(const std::string& file);
  ~FileLock();
  FileLock(FileLock&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  FileLock& operator=(FileLock&&) = delete;

 private:
  explicit FileLock(int descriptor) : descriptor_(descriptor) {}

  int descriptor_;
};

}  // namespace enfilade::client
