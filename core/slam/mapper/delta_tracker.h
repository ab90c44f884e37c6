// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <set>
#include <vector>

#include "core/slam/loops/slam_graph.h"
#include "core/slam/slam_map.h"
#include "core/slam/state/mapper_state.h"

namespace enfilade::slam {

// Tracks which rows have changed since the last Take, and the new points of the trajectory.
class DeltaTracker {
 public:
  void MarkNode(std::int64_t id) { nodes_.insert(id); }
  void MarkSubmap(std::int64_t id) { submaps_.insert(id); }
  // Marks a finished submap whose content has changed: its row includes the content.
  void MarkContent(std::int64_t id);
  void MarkLoopClosure(std::int64_t id) { loop_closures_.insert(id); }
  void Mark(const GraphChange& change);
  void Append(const TrajectoryPoint& point) { trajectory_.push_back(point); }

  // The marked rows as they are in `state`. Clears all marks.
  SlamDelta Take(const MapperState& state);

 private:
  SlamSubmap RowOf(std::int64_t id, const MapperState& state) const;

  std::set<std::int64_t> nodes_;
  std::set<std::int64_t> submaps_;
  std::set<std::int64_t> contents_;  // subset of `submaps_`
  std::set<std::int64_t> loop_closures_;
  std::vector<TrajectoryPoint> trajectory_;
};

}  // namespace enfilade::slam
