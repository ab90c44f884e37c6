// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>

#include "absl/status/statusor.h"

namespace enfilade::client {

// Reserves a file for one process, by flock on "FILE.lock". The system releases it when the process ends, even if it is
// killed.
class FileLock {
 public:
  // FAILED_PRECONDITION: another process, which the message names, has it.
  static absl::StatusOr<FileLock> Take(const std::string& file);
  ~FileLock();
  FileLock(FileLock&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  FileLock& operator=(FileLock&&) = delete;

 private:
  explicit FileLock(int descriptor) : descriptor_(descriptor) {}

  int descriptor_;
};

}  // namespace enfilade::client
