// SPDX-License-Identifier: Apache-2.0
#include "core/slam/loops/submap_cache.h"

#include <algorithm>
#include <utility>

namespace enfilade::slam {
namespace {

// Moves the item to the front. Null: it is not there.
template <typename Item>
Item* Use(std::list<Item>& items, std::int64_t id) {
  const auto found = std::find_if(items.begin(), items.end(), [&](const Item& item) { return item.id == id; });
  if (found == items.end()) return nullptr;
  items.splice(items.begin(), items, found);
  return &items.front();
}

}  // namespace

const SearchableSubmap& SubmapCache::Get(std::int64_t id, const FinishedSubmap& submap) {
  if (const Entry* entry = Use(entries_, id)) return entry->submap;
  const Grid* known = Use(grids_, id);
  SubmapGrid grid = known ? known->grid : DecodeSubmapContent(submap.content, options_.occupancy)->grid;
  entries_.push_front({id, SearchableSubmap(std::move(grid), options_.pyramid)});
  if (entries_.size() > static_cast<std::size_t>(options_.loop.cached_submaps)) entries_.pop_back();
  return entries_.front().submap;
}

const SubmapGrid& SubmapCache::GetGrid(std::int64_t id, const FinishedSubmap& submap) {
  if (const Grid* known = Use(grids_, id)) return known->grid;
  if (const Entry* entry = Use(entries_, id)) return entry->submap.grid;
  return Put(id, DecodeSubmapContent(submap.content, options_.occupancy)->grid);
}

const SubmapGrid& SubmapCache::Put(std::int64_t id, SubmapGrid grid) {
  grids_.push_front({id, std::move(grid)});
  if (grids_.size() > most_grids_) grids_.pop_back();
  return grids_.front().grid;
}

std::size_t SubmapCache::bytes() const {
  std::size_t bytes = 0;
  for (const Entry& entry : entries_) {
    bytes += sizeof(Entry) + entry.submap.grid.bytes() + entry.submap.pyramid.bytes();
  }
  for (const Grid& grid : grids_) bytes += sizeof(Grid) + grid.grid.bytes();
  return bytes;
}

}  // namespace enfilade::slam
