// SPDX-License-Identifier: Apache-2.0
#include "server/app/survey/drive_cache.h"

#include <iterator>
#include <utility>

#include "core/base/status_macros.h"

namespace enfilade::server {

absl::StatusOr<const MappedDrive*> DriveCache::Get(const std::string& id,
                                                   const std::function<absl::Status(CachedDrive&)>& update) {
  Entry& entry = drives_[id];
  entry.used = true;
  ENFILADE_RETURN_IF_ERROR(update(entry.drive));
  return &entry.drive.mapped;
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
