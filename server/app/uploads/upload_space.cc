// SPDX-License-Identifier: Apache-2.0
#include "server/app/uploads/upload_space.h"

namespace enfilade::server {

UploadSpace::Use UploadSpace::use() const {
  MutexLock lock(mutex_);
  return use_;
}

bool UploadSpace::TakeMemory(std::int64_t bytes) {
  MutexLock lock(mutex_);
  if (bytes > options_.memory_bytes - use_.memory_bytes) return false;
  use_.memory_bytes += bytes;
  if (on_change_) on_change_(use_);
  return true;
}

bool UploadSpace::TakeDisk(std::int64_t bytes) {
  MutexLock lock(mutex_);
  if (bytes > options_.disk_bytes - use_.disk_bytes) return false;
  use_.disk_bytes += bytes;
  if (on_change_) on_change_(use_);
  return true;
}

void UploadSpace::Return(const Use& use) {
  if (use.memory_bytes == 0 && use.disk_bytes == 0) return;
  MutexLock lock(mutex_);
  use_.memory_bytes -= use.memory_bytes;
  use_.disk_bytes -= use.disk_bytes;
  if (on_change_) on_change_(use_);
}

}  // namespace enfilade::server
