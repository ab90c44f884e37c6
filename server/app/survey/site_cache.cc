// SPDX-License-Identifier: Apache-2.0
#include "server/app/survey/site_cache.h"

#include <algorithm>
#include <utility>

namespace enfilade::server {

const rooms::RoomPartition& RoomCache::Get(const grid::OccupancyGrid& grid, std::vector<rooms::PassageHint> passages,
                                           std::vector<Eigen::Vector2d> trajectory) {
  const bool same = valid_ && grid == grid_ && passages == passages_ && trajectory == trajectory_;
  if (same) return partition_;
  grid_ = grid;
  passages_ = std::move(passages);
  trajectory_ = std::move(trajectory);
  partition_ = rooms::PartitionRooms(grid_, {}, {.passages = passages_, .trajectory = trajectory_});
  valid_ = true;
  return partition_;
}

std::size_t RoomCache::bytes() const {
  return sizeof(*this) + grid_.cells.size() + partition_.labels.size() * sizeof(std::uint16_t) +
         trajectory_.size() * sizeof(Eigen::Vector2d);
}

std::size_t SiteCache::bytes() const {
  std::size_t bytes = drives.bytes();
  for (const auto& [level, cache] : rooms) bytes += cache.bytes();
  return bytes;
}

SiteCache& SiteCaches::Get(const SiteId& site) {
  Entry& entry = sites_[site];
  entry.asked = ++asked_;
  return entry.cache;
}

void SiteCaches::Trim() {
  std::size_t bytes = 0;
  for (const auto& [site, entry] : sites_) bytes += entry.cache.bytes();
  while (bytes > max_bytes_ && sites_.size() > 1) {
    const auto oldest = std::min_element(sites_.begin(), sites_.end(),
                                         [](const auto& a, const auto& b) { return a.second.asked < b.second.asked; });
    bytes -= oldest->second.cache.bytes();
    sites_.erase(oldest);
  }
}

}  // namespace enfilade::server
