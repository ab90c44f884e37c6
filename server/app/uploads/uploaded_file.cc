// SPDX-License-Identifier: Apache-2.0
#include "server/app/uploads/uploaded_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "server/app/runtime/retry_hint.h"

namespace enfilade::server {
namespace {

// Uploads that make no progress end within the default deadline.
constexpr auto kRetryAfter = std::chrono::seconds(10);

absl::Status NoSpace() {
  return WithRetryHint(
      ResourceExhausted("uploads under way fill their space (transfers.upload_disk_bytes): try again later"),
      kRetryAfter);
}

absl::Status FileError(const std::string& directory, const char* doing) {
  const int error = errno;
  if (error == ENOSPC || error == EDQUOT) {
    return WithRetryHint(
        ResourceExhausted("the disk of {} is full (transfers.upload_directory): try again later", directory),
        kRetryAfter);
  }
  return Unavailable("{} a file in {}: {}", doing, directory, std::strerror(error));
}

// Without a name, so that nobody has to delete it. Not all file systems can do that at once.
absl::StatusOr<int> OpenNameless(const std::string& directory) {
  const int descriptor = open(directory.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  if (descriptor >= 0) return descriptor;
  std::string path = directory + "/enfilade-upload-XXXXXX";
  const int named = mkostemp(path.data(), O_CLOEXEC);
  if (named < 0) return FileError(directory, "making");
  unlink(path.c_str());
  return named;
}

}  // namespace

UploadedFile::UploadedFile(UploadedFile&& other) noexcept
    : space_(other.space_),
      size_(std::exchange(other.size_, 0)),
      memory_(std::exchange(other.memory_, {})),
      descriptor_(std::exchange(other.descriptor_, -1)) {}

UploadedFile& UploadedFile::operator=(UploadedFile&& other) noexcept {
  if (this == &other) return *this;
  Release();
  space_ = other.space_;
  size_ = std::exchange(other.size_, 0);
  memory_ = std::exchange(other.memory_, {});
  descriptor_ = std::exchange(other.descriptor_, -1);
  return *this;
}

absl::Status UploadedFile::Append(std::string_view bytes) {
  const auto added = static_cast<std::int64_t>(bytes.size());
  if (!is_on_disk()) {
    if (size_ + added <= kMaxInMemory && space_->TakeMemory(added)) {
      memory_ += bytes;
      size_ += added;
      return absl::OkStatus();
    }
    ENFILADE_RETURN_IF_ERROR(MoveToDisk());
  }
  if (!space_->TakeDisk(added)) return NoSpace();
  size_ += added;
  return Write(bytes);
}

absl::StatusOr<std::string> UploadedFile::Take() {
  std::string bytes;
  if (is_on_disk()) {
    bytes.resize(static_cast<std::size_t>(size_));
    for (std::size_t done = 0; done < bytes.size();) {
      const ssize_t count = pread(descriptor_, bytes.data() + done, bytes.size() - done, static_cast<off_t>(done));
      if (count < 0 && errno == EINTR) continue;
      if (count < 0) return FileError(space_->options().directory, "reading");
      if (count == 0) return Unavailable("a file in {} has become shorter", space_->options().directory);
      done += static_cast<std::size_t>(count);
    }
  } else {
    bytes = std::move(memory_);
  }
  Release();
  return bytes;
}

absl::Status UploadedFile::MoveToDisk() {
  if (!space_->TakeDisk(size_)) return NoSpace();
  const auto opened = OpenNameless(space_->options().directory);
  if (!opened.ok()) {
    space_->Return({.disk_bytes = size_});
    return opened.status();
  }
  descriptor_ = *opened;
  space_->Return({.memory_bytes = size_});
  return Write(std::exchange(memory_, {}));
}

absl::Status UploadedFile::Write(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t count = write(descriptor_, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return FileError(space_->options().directory, "writing");
    bytes.remove_prefix(static_cast<std::size_t>(count));
  }
  return absl::OkStatus();
}

void UploadedFile::Release() {
  if (is_on_disk()) {
    close(std::exchange(descriptor_, -1));
    space_->Return({.disk_bytes = size_});
  } else {
    space_->Return({.memory_bytes = size_});
  }
  size_ = 0;
  memory_ = {};
}

}  // namespace enfilade::server
