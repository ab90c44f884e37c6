// SPDX-License-Identifier: Apache-2.0
#include "client/sdk/spool/file_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>

#include "core/base/error.h"

namespace enfilade::client {

absl::StatusOr<FileLock> FileLock::Take(const std::string& file) {
  const std::string path = file + ".lock";
  const int descriptor = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (descriptor < 0) return absl::ErrnoToStatus(errno, path + ": cannot be opened");
  FileLock lock(descriptor);
  if (flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK) return absl::ErrnoToStatus(errno, path + ": cannot be locked");
    char holder[32] = {};
    const ssize_t size = pread(descriptor, holder, sizeof(holder) - 1, 0);
    return FailedPrecondition("{}: in use by process {}: only one process at a time may use a spool", file,
                              size > 0 ? holder : "?");
  }
  const std::string pid = std::to_string(getpid());
  // The number is for messages only, so a failed write does not matter.
  if (ftruncate(descriptor, 0) == 0) [[maybe_unused]]
    const ssize_t ignored = pwrite(descriptor, pid.data(), pid.size(), 0);
  return lock;
}

FileLock::~FileLock() {
  if (descriptor_ >= 0) close(descriptor_);
}

}  // namespace enfilade::client
