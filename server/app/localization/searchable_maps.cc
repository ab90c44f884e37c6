// SPDX-License-Identifier: Apache-2.0
#include "server/app/localization/searchable_maps.h"

#include <algorithm>
#include <utility>

#include "core/base/status_macros.h"
#include "server/app/mapping/raster_revision.h"

namespace enfilade::server {
namespace {

constexpr double kCell = 0.05;  // m

}  // namespace

absl::StatusOr<std::shared_ptr<const localization::SearchableMap>> SearchableMaps::Get(
    const storage::CallContext& context, const storage::MapRevision& revision) {
  if (auto known = Find(revision)) return known;
  // Two calls that need the same map at once both build it. That is rare, and no call waits for another's deadline.
  ENFILADE_ASSIGN_OR_RETURN(const grid::MapRaster raster, ReadEvidence(context, stores_, revision));
  ENFILADE_ASSIGN_OR_RETURN(const grid::OccupancyGrid grid, OnMapLattice(raster, kCell));
  auto map = std::make_shared<const localization::SearchableMap>(grid, localization::LocalizationOptions());
  const std::size_t bytes = map->bytes();
  Keep({revision.site.value(), revision.content_sha256, map, bytes});
  return map;
}

std::size_t SearchableMaps::bytes() const {
  const MutexLock lock(mutex_);
  return bytes_;
}

std::shared_ptr<const localization::SearchableMap> SearchableMaps::Find(const storage::MapRevision& revision) {
  const MutexLock lock(mutex_);
  const auto found = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& entry) {
    return entry.content_sha256 == revision.content_sha256 && entry.site == revision.site.value();
  });
  if (found == entries_.end()) return nullptr;
  entries_.splice(entries_.begin(), entries_, found);
  return entries_.front().map;
}

void SearchableMaps::Keep(Entry entry) {
  const MutexLock lock(mutex_);
  bytes_ += entry.bytes;
  entries_.push_front(std::move(entry));
  while (bytes_ > max_bytes_ && !entries_.empty()) {
    bytes_ -= entries_.back().bytes;
    entries_.pop_back();
  }
}

}  // namespace enfilade::server
