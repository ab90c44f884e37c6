// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <list>

#include "core/slam/matching/field_pyramid.h"
#include "core/slam/slam_options.h"
#include "core/slam/submaps/finished_submap.h"

namespace enfilade::slam {

// The submaps last used by loop closing, decompressed, with their pyramids: at most `loop.cached_submaps`. The result
// of Get depends on the submap only, not on earlier calls.
class SubmapCache {
 public:
  explicit SubmapCache(const SlamOptions& options) : options_(options) {}

  // `submap.content` must be valid: finished by this program, or checked when restored. The reference is valid until
  // the next call.
  const SearchableSubmap& Get(std::int64_t id, const FinishedSubmap& submap);

  // Bytes of memory held.
  std::size_t bytes() const;

 private:
  struct Entry {
    std::int64_t id = 0;
    SearchableSubmap submap;
  };

  SlamOptions options_;
  std::list<Entry> entries_;  // most recently used first
};

}  // namespace enfilade::slam
