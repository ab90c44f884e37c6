// SPDX-License-Identifier: Apache-2.0
#include "core/slam/submaps/submap_cache.h"

#include <algorithm>
#include <utility>

namespace enfilade::slam {

const SubmapCache::Entry& SubmapCache::Get(std::int64_t id, const FinishedSubmap& submap) {
  const auto found = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& e) { return e.id == id; });
  if (found != entries_.end()) {
    entries_.splice(entries_.begin(), entries_, found);
    return entries_.front();
  }
  SubmapGrid grid = DecodeSubmapContent(submap.content, options_.occupancy)->grid;
  FieldPyramid pyramid(grid, options_.pyramid);
  entries_.push_front({id, std::move(grid), std::move(pyramid)});
  if (entries_.size() > static_cast<std::size_t>(options_.loop.cached_submaps)) entries_.pop_back();
  return entries_.front();
}

std::size_t SubmapCache::bytes() const {
  std::size_t bytes = 0;
  for (const Entry& entry : entries_) bytes += sizeof(Entry) + entry.grid.bytes() + entry.pyramid.bytes();
  return bytes;
}

}  // namespace enfilade::slam
