// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <list>
#include <memory>

#include "core/slam/mapper/mapper_state.h"
#include "core/slam/matching/field_pyramid.h"
#include "core/slam/slam_options.h"

namespace enfilade::slam {

// The submaps last used by loop closing, decompressed, with their pyramids: at most `loop.cached_submaps`. What it
// gives depends on the submap only, never on what was asked before.
class SubmapCache {
 public:
  struct Entry {
    std::int64_t id = 0;
    SubmapGrid grid;
    FieldPyramid pyramid;
  };

  explicit SubmapCache(const SlamOptions& options) : options_(options) {}

  // `submap` is one that this program finished or has checked on restoring.
  const Entry& Get(std::int64_t id, const FinishedSubmap& submap);

  // Bytes of memory held.
  std::size_t bytes() const;

 private:
  SlamOptions options_;
  std::list<Entry> entries_;  // the last used first
};

}  // namespace enfilade::slam
