// SPDX-License-Identifier: Apache-2.0
#include "core/slam/mapper/delta_tracker.h"

#include <utility>

namespace enfilade::slam {

void DeltaTracker::MarkContent(std::int64_t id) {
  submaps_.insert(id);
  contents_.insert(id);
}

void DeltaTracker::Mark(const GraphChange& change) {
  nodes_.insert(change.nodes.begin(), change.nodes.end());
  submaps_.insert(change.submaps.begin(), change.submaps.end());
  loop_closures_.insert(change.loop_closures.begin(), change.loop_closures.end());
}

SlamDelta DeltaTracker::Take(const MapperState& state) {
  SlamDelta delta;
  for (const std::int64_t id : nodes_) delta.nodes.push_back(state.nodes.at(id));
  for (const std::int64_t id : submaps_) delta.submaps.push_back(RowOf(id, state));
  for (const std::int64_t id : loop_closures_) delta.loop_closures.push_back(state.loop_closures.at(id));
  delta.trajectory = std::move(trajectory_);
  *this = {};
  return delta;
}

SlamSubmap DeltaTracker::RowOf(std::int64_t id, const MapperState& state) const {
  SlamSubmap row;
  row.id = id;
  if (state.active && state.active->id == id) {
    row.version = state.active->version;
    row.T_map_submap = state.active->T_map_submap;
    return row;
  }
  const FinishedSubmap& submap = state.finished.at(id);
  row.version = submap.version;
  row.T_map_submap = submap.T_map_submap;
  row.finished = true;
  if (contents_.contains(id)) row.content = submap.content;
  return row;
}

}  // namespace enfilade::slam
