// SPDX-License-Identifier: Apache-2.0
#include "io/file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <system_error>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace enfilade::io {
namespace {

constexpr std::size_t kReadBytes = 1U << 16;

class Descriptor {
 public:
  Descriptor(const std::filesystem::path& path, int flags) : value_(open(path.c_str(), flags | O_CLOEXEC, 0666)) {}
  ~Descriptor() {
    if (value_ >= 0) close(value_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  int value() const { return value_; }
  // Some file systems report a full disk or quota only here.
  bool Close() { return close(std::exchange(value_, -1)) == 0; }

 private:
  int value_;
};

absl::Status CannotRead(const std::filesystem::path& path, int error) {
  return FileError(path, "cannot be read", error);
}

absl::Status CannotWrite(const std::filesystem::path& path, int error) {
  if (error == ENOENT || error == ENOTDIR)
    return FailedPrecondition("{}: cannot be written: its folder does not exist", path.string());
  return FileError(path, "cannot be written", error);
}

}  // namespace

absl::Status FileError(const std::filesystem::path& path, std::string_view what, int error) {
  switch (error) {
    case ENOENT:
    case ENOTDIR:
      return NotFound("{}: no such file", path.string());
    case EISDIR:
      return InvalidArgument("{}: is a folder", path.string());
    case EACCES:
    case EPERM:
    case EROFS:
      return absl::PermissionDeniedError(
          fmt::format("{}: {}: {}", path.string(), what, std::generic_category().message(error)));
    case ENOSPC:
    case EDQUOT:
      return ResourceExhausted("{}: {}: the disk is full", path.string(), what);
    default:
      return Internal("{}: {}: {}", path.string(), what, std::generic_category().message(error));
  }
}

absl::StatusOr<std::string> ReadFile(const std::filesystem::path& path) {
  const Descriptor file(path, O_RDONLY);
  if (file.value() < 0) return CannotRead(path, errno);
  std::string bytes;
  // The size is a hint only: pipes and files under /proc have none, and a file may grow while it is read.
  struct stat status {};
  if (fstat(file.value(), &status) == 0 && S_ISREG(status.st_mode)) {
    bytes.reserve(static_cast<std::size_t>(status.st_size) + 1);
  }
  while (true) {
    const std::size_t size = bytes.size();
    bytes.resize(std::max(bytes.capacity(), size + kReadBytes));
    const ssize_t count = read(file.value(), bytes.data() + size, bytes.size() - size);
    const int error = errno;
    bytes.resize(size + static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
    if (count == 0) return bytes;
    if (count < 0 && error != EINTR) return CannotRead(path, error);
  }
}

absl::Status WriteFile(const std::filesystem::path& path, std::string_view bytes) {
  Descriptor file(path, O_WRONLY | O_CREAT | O_TRUNC);
  if (file.value() < 0) return CannotWrite(path, errno);
  while (!bytes.empty()) {
    const ssize_t count = write(file.value(), bytes.data(), bytes.size());
    if (count < 0 && errno != EINTR) return CannotWrite(path, errno);
    bytes.remove_prefix(static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
  }
  return file.Close() ? absl::OkStatus() : CannotWrite(path, errno);
}

}  // namespace enfilade::io
