// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "absl/status/statusor.h"

namespace enfilade::server {

// A new folder of this process, which it keeps locked (flock) so that others see that it is in use, in whatever process
// namespace they are. The kernel releases the lock with the process. The destructor removes the folder.
class LockedDirectory {
 public:
  // FAILED_PRECONDITION naming the folder. Its name begins with `prefix`.
  static absl::StatusOr<LockedDirectory> Create(const std::filesystem::path& parent, const std::string& prefix);
  // Removes the folders of processes that were killed.
  static void RemoveAbandoned(const std::filesystem::path& parent, const std::string& prefix);

  ~LockedDirectory();
  LockedDirectory(LockedDirectory&& other) noexcept;
  LockedDirectory& operator=(LockedDirectory&&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  LockedDirectory(std::filesystem::path path, int descriptor);

  std::filesystem::path path_;
  int descriptor_;  // -1: moved from
};

}  // namespace enfilade::server
