// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "core/grid/scan_rays.h"
#include "core/slam/loops/submap_cache.h"
#include "core/slam/mapper/delta_tracker.h"
#include "core/slam/slam_options.h"
#include "core/slam/state/mapper_state.h"

namespace enfilade::slam {

// Closes loops and solves the pose graph while a map grows: the back end of SLAM. Marks the rows that change. One
// belongs to one growing state.
class BackEnd {
 public:
  // `cache_bytes`: those of SubmapCache.
  explicit BackEnd(const SlamOptions& options, std::size_t cache_bytes = 0)
      : options_(options), cache_(options, cache_bytes) {}

  // Looks for the keyframe in earlier submaps, and solves the graph if that is due.
  void CloseLoops(const SlamNode& node, const grid::ScanRays& rays, MapperState& state);
  // Adds closures with the next ids, without solving the graph.
  void Add(std::vector<LoopClosure> closures, MapperState& state);
  // There are no more scans: solves the graph. `join`: also compares what no closure has joined.
  void Finish(bool join, MapperState& state);

  DeltaTracker& changes() { return changes_; }
  // Of finished submaps.
  SubmapCache& submaps() { return cache_; }
  // Bytes of memory held between calls.
  std::size_t bytes() const { return cache_.bytes(); }

 private:
  void Solve(MapperState& state);
  void Reconsider(MapperState& state);
  void JoinUnjoined(MapperState& state);

  SlamOptions options_;
  DeltaTracker changes_;
  SubmapCache cache_;
};

}  // namespace enfilade::slam
