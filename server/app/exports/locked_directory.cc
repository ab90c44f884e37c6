// SPDX-License-Identifier: Apache-2.0
#include "server/app/exports/locked_directory.h"

#include <fcntl.h>
#include <stdlib.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

#include "core/base/error.h"

namespace enfilade::server {
namespace {

namespace fs = std::filesystem;

constexpr int kAttempts = 10;

// -1 if the folder is gone, or locked by another process.
int LockIfFree(const fs::path& path) {
  const int descriptor = open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC | O_NOFOLLOW);
  if (descriptor < 0) return -1;
  struct stat opened {
  }, named{};
  const bool locked = flock(descriptor, LOCK_EX | LOCK_NB) == 0 && fstat(descriptor, &opened) == 0 &&
                      stat(path.c_str(), &named) == 0 && opened.st_ino == named.st_ino;
  if (locked) return descriptor;
  close(descriptor);
  return -1;
}

}  // namespace

LockedDirectory::LockedDirectory(fs::path path, int descriptor) : path_(std::move(path)), descriptor_(descriptor) {}

LockedDirectory::LockedDirectory(LockedDirectory&& other) noexcept
    : path_(std::move(other.path_)), descriptor_(std::exchange(other.descriptor_, -1)) {}

LockedDirectory::~LockedDirectory() {
  if (descriptor_ < 0) return;
  std::error_code ignored;
  fs::remove_all(path_, ignored);
  close(descriptor_);
}

absl::StatusOr<LockedDirectory> LockedDirectory::Create(const fs::path& parent, const std::string& prefix) {
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    std::string path = parent / (prefix + "XXXXXX");
    if (mkdtemp(path.data()) == nullptr) {
      return FailedPrecondition("cannot create a folder in {}: {}", parent.string(), std::strerror(errno));
    }
    // Another process may have taken it for abandoned before it was locked.
    const int descriptor = LockIfFree(path);
    if (descriptor >= 0) return LockedDirectory(path, descriptor);
  }
  return FailedPrecondition("cannot lock a folder in {}", parent.string());
}

void LockedDirectory::RemoveAbandoned(const fs::path& parent, const std::string& prefix) {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(parent, error)) {
    if (!entry.path().filename().string().starts_with(prefix)) continue;
    const int descriptor = LockIfFree(entry.path());
    if (descriptor < 0) continue;
    const LockedDirectory abandoned(entry.path(), descriptor);  // removes it
  }
}

}  // namespace enfilade::server
