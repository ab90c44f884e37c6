// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <iterator>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/status_macros.h"
#include "core/grid/occupancy_grid.h"
#include "core/slam/slam_map.h"

namespace enfilade::server {

// A drive from end to end, in its level's frame.
struct MappedDrive {
  grid::OccupancyGrid grid;                   // of this drive alone; no cells: nothing could be mapped
  std::vector<slam::StampedPose> trajectory;  // by time
  double variance_factor = 1.0;               // of its SLAM
};

// What the last survey of a site has mapped: while a survey's rearrangements are applied, it is made again and again
// from the same records. Not thread-safe.
class DriveCache {
 public:
  // The drive with this key; `map` maps it if it is not there. Valid until DropUnused.
  absl::StatusOr<const MappedDrive*> Get(const std::string& key,
                                         const std::function<absl::StatusOr<MappedDrive>()>& map) {
    auto found = drives_.find(key);
    if (found == drives_.end()) {
      ENFILADE_ASSIGN_OR_RETURN(MappedDrive mapped, map());
      found = drives_.emplace(key, Entry{std::move(mapped), false}).first;
    }
    found->second.used = true;
    return &found->second.drive;
  }

  // Forgets the drives that were not asked for since the last call.
  void DropUnused() {
    for (auto entry = drives_.begin(); entry != drives_.end();) {
      entry = std::exchange(entry->second.used, false) ? std::next(entry) : drives_.erase(entry);
    }
  }

 private:
  struct Entry {
    MappedDrive drive;
    bool used = false;
  };
  std::map<std::string, Entry> drives_;
};

}  // namespace enfilade::server
