// SPDX-License-Identifier: Apache-2.0
#include "server/app/survey/drive_cache.h"

#include <iterator>
#include <utility>

#include "core/base/status_macros.h"
#include "core/compression/compression.h"

namespace enfilade::server {

PackedDrive::PackedDrive(slam::ChainedMap drive) : rest_(std::move(drive)), cell_count_(rest_.grid.cells.size()) {
  const std::vector<std::uint8_t> cells = std::exchange(rest_.grid.cells, {});
  cells_ = Compress({reinterpret_cast<const char*>(cells.data()), cells.size()});
}

absl::StatusOr<slam::ChainedMap> PackedDrive::Unpack() const {
  slam::ChainedMap drive = rest_;
  if (cell_count_ == 0) return drive;
  ENFILADE_ASSIGN_OR_RETURN(const std::string cells, Decompress(cells_, cell_count_));
  drive.grid.cells.assign(cells.begin(), cells.end());
  return drive;
}

std::size_t PackedDrive::bytes() const {
  return sizeof(*this) + cells_.size() + rest_.trajectory.size() * sizeof(slam::StampedPose);
}

absl::StatusOr<slam::ChainedMap> DriveCache::Get(const std::string& id,
                                                 const std::function<absl::Status(CachedDrive&)>& update) {
  Entry& entry = drives_[id];
  entry.used = true;
  ENFILADE_RETURN_IF_ERROR(update(entry.drive));
  return entry.drive.mapped.Unpack();
}

void DriveCache::DropUnused() {
  for (auto entry = drives_.begin(); entry != drives_.end();) {
    entry = std::exchange(entry->second.used, false) ? std::next(entry) : drives_.erase(entry);
  }
}

std::size_t DriveCache::bytes() const {
  std::size_t bytes = 0;
  for (const auto& [id, entry] : drives_) {
    bytes += entry.drive.mapped.bytes() + (entry.drive.chain ? entry.drive.chain->bytes() : 0);
  }
  return bytes;
}

}  // namespace enfilade::server
