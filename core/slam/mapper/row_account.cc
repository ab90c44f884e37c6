// SPDX-License-Identifier: Apache-2.0
#include "core/slam/mapper/row_account.h"

#include <utility>

namespace enfilade::slam {

void RowAccount::Touch(const GraphChange& change) {
  nodes_.insert(change.nodes.begin(), change.nodes.end());
  submaps_.insert(change.submaps.begin(), change.submaps.end());
  closures_.insert(change.closures.begin(), change.closures.end());
}

SlamDelta RowAccount::Take(const MapperState& state) {
  SlamDelta delta;
  for (const std::int64_t id : nodes_) delta.nodes.push_back(state.nodes.at(id));
  for (const std::int64_t id : submaps_) delta.submaps.push_back(RowOf(id, state));
  for (const std::int64_t id : closures_) delta.closures.push_back(state.closures.at(id));
  delta.trajectory = std::move(trajectory_);
  *this = {};
  return delta;
}

SlamSubmap RowAccount::RowOf(std::int64_t id, const MapperState& state) const {
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
