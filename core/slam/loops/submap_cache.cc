// SPDX-License-Identifier: Apache-2.0
#include "core/slam/loops/submap_cache.h"

#include <algorithm>
#include <numeric>
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

template <typename Item>
std::size_t BytesOf(const std::list<Item>& items) {
  return std::accumulate(items.begin(), items.end(), std::size_t{0},
                         [](std::size_t bytes, const Item& item) { return bytes + item.bytes(); });
}

// Drops the items that were not used for longest, but for `least`, until no more than `bytes` are left.
template <typename Item>
void Trim(std::list<Item>& items, std::size_t least, std::size_t bytes) {
  if (items.size() <= least) return;
  for (std::size_t held = BytesOf(items); items.size() > least && held > bytes; items.pop_back()) {
    held -= items.back().bytes();
  }
}

}  // namespace

const SearchableSubmap& SubmapCache::Get(std::int64_t id, const FinishedSubmap& submap) {
  if (const Entry* entry = Use(entries_, id)) return entry->submap;
  const Grid* known = Use(grids_, id);
  SubmapGrid grid = known ? known->grid : DecodeSubmapContent(submap.content, options_.occupancy)->grid;
  entries_.push_front({id, SearchableSubmap(std::move(grid), options_.pyramid)});
  Trim(entries_, static_cast<std::size_t>(options_.loop.cached_submaps), kept_bytes_);
  return entries_.front().submap;
}

const SubmapGrid& SubmapCache::GetGrid(std::int64_t id, const FinishedSubmap& submap) {
  if (const Grid* known = Use(grids_, id)) return known->grid;
  if (const Entry* entry = Use(entries_, id)) return entry->submap.grid;
  return Put(id, DecodeSubmapContent(submap.content, options_.occupancy)->grid);
}

const SubmapGrid& SubmapCache::Put(std::int64_t id, SubmapGrid grid) {
  grids_.push_front({id, std::move(grid)});
  Trim(grids_, 1, kept_bytes_);
  return grids_.front().grid;
}

std::size_t SubmapCache::bytes() const { return BytesOf(entries_) + BytesOf(grids_); }

}  // namespace enfilade::slam
