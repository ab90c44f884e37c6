// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <list>

#include "core/slam/matching/field_pyramid.h"
#include "core/slam/slam_options.h"
#include "core/slam/submaps/finished_submap.h"

namespace enfilade::slam {

// The submaps last used by loop closing, decompressed: `loop.cached_submaps` with their pyramids, and one grid without;
// of each kind more, as long as they take no more than `bytes`. What is returned depends on the submap only, not on
// earlier calls, and is valid until the next one. `submap.content` must be valid: finished by this program, or checked
// when restored.
class SubmapCache {
 public:
  explicit SubmapCache(const SlamOptions& options, std::size_t bytes = 0) : options_(options), kept_bytes_(bytes) {}

  const SearchableSubmap& Get(std::int64_t id, const FinishedSubmap& submap);
  const SubmapGrid& GetGrid(std::int64_t id, const FinishedSubmap& submap);
  // A submap's grid that is decompressed already.
  const SubmapGrid& Put(std::int64_t id, SubmapGrid grid);

  // Bytes of memory held.
  std::size_t bytes() const;

 private:
  struct Entry {
    std::int64_t id = 0;
    SearchableSubmap submap;

    std::size_t bytes() const { return sizeof(Entry) + submap.grid.bytes() + submap.pyramid.bytes(); }
  };
  struct Grid {
    std::int64_t id = 0;
    SubmapGrid grid;

    std::size_t bytes() const { return sizeof(Grid) + grid.bytes(); }
  };

  SlamOptions options_;
  std::size_t kept_bytes_;
  std::list<Entry> entries_;  // most recently used first
  std::list<Grid> grids_;     // the same
};

}  // namespace enfilade::slam
