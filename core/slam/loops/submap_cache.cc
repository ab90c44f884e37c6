// SPDX-License-Identifier: Apache-2.0
#include "core/slam/loops/submap_cache.h"

#include <algorithm>
#include <utility>

namespace enfilade::slam {

const SearchableSubmap& SubmapCache::Get(std::int64_t id, const FinishedSubmap& submap) {
  const auto found = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& e) { return e.id == id; });
  if (found != entries_.end()) {
    entries_.splice(entries_.begin(), entries_, found);
    return entries_.front().submap;
  }
  SubmapGrid grid = DecodeSubmapContent(submap.content, options_.occupancy)->grid;
  entries_.push_front({id, SearchableSubmap(std::move(grid), options_.pyramid)});
  if (entries_.size() > static_cast<std::size_t>(options_.loop.cached_submaps)) entries_.pop_back();
  return entries_.front().submap;
}

std::size_t SubmapCache::bytes() const {
  std::size_t bytes = 0;
  for (const Entry& entry : entries_) {
    bytes += sizeof(Entry) + entry.submap.grid.bytes() + entry.submap.pyramid.bytes();
  }
  return bytes;
}

}  // namespace enfilade::slam
