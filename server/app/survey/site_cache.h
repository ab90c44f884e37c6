// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "core/base/ids.h"
#include "core/grid/occupancy_grid.h"
#include "core/rooms/room_partition.h"
#include "server/app/survey/drive_cache.h"

namespace enfilade::server {

// The rooms of one level, found again only if the level has changed. Not thread-safe.
class RoomCache {
 public:
  // As rooms::PartitionRooms. Valid until the next call.
  const rooms::RoomPartition& Get(const grid::OccupancyGrid& grid, std::vector<rooms::PassageHint> passages,
                                  std::vector<Eigen::Vector2d> trajectory);

  // Memory held, about.
  std::size_t bytes() const;

 private:
  bool valid_ = false;
  grid::OccupancyGrid grid_;
  std::vector<rooms::PassageHint> passages_;
  std::vector<Eigen::Vector2d> trajectory_;
  rooms::RoomPartition partition_;
};

// What a survey of a site leaves for the next one.
struct SiteCache {
  DriveCache drives;
  std::map<int, RoomCache> rooms;  // by level

  std::size_t bytes() const;
};

// Those of the sites that were surveyed last. Not thread-safe.
class SiteCaches {
 public:
  explicit SiteCaches(std::size_t max_bytes) : max_bytes_(max_bytes) {}

  // Valid until the next call of Trim.
  SiteCache& Get(const SiteId& site);
  // Forgets the sites that have not been asked for longest, until the others fit; the last one stays.
  void Trim();

  std::size_t size() const { return sites_.size(); }

 private:
  struct Entry {
    SiteCache cache;
    std::uint64_t asked = 0;  // a count of calls of Get
  };
  const std::size_t max_bytes_;
  std::uint64_t asked_ = 0;
  std::map<SiteId, Entry> sites_;
};

}  // namespace enfilade::server
