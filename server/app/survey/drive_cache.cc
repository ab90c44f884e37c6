// SPDX-License-Identifier: Apache-2.0
#include "server/app/survey/drive_cache.h"

#include <iterator>
#include <utility>

namespace enfilade::server {

absl::StatusOr<const MappedDrive*> DriveCache::Get(const std::string& id,
                                                   const std::function<absl::Status(CachedDrive&)>& update) {
  const auto entry = drives_.try_emplace(id).first;
  CachedDrive& drive = entry->second.drive;
  if (absl::Status status = update(drive); !status.ok()) {
    drives_.erase(entry);  // it may contain a part of what is new
    return status;
  }
  entry->second.used = true;
  return &drive.mapped;
}

void DriveCache::DropUnused() {
  for (auto entry = drives_.begin(); entry != drives_.end();) {
    entry = std::exchange(entry->second.used, false) ? std::next(entry) : drives_.erase(entry);
  }
}

std::size_t DriveCache::bytes() const {
  std::size_t bytes = 0;
  for (const auto& [id, entry] : drives_) {
    bytes += entry.drive.mapped.bytes() + (entry.drive.growing ? entry.drive.growing->bytes() : 0);
  }
  return bytes;
}

}  // namespace enfilade::server
