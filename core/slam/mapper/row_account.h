// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <set>

#include "core/slam/loops/slam_graph.h"
#include "core/slam/mapper/mapper_state.h"
#include "core/slam/slam_map.h"

namespace enfilade::slam {

// Which rows have changed since the last account, and the trajectory's new points.
class RowAccount {
 public:
  void TouchNode(std::int64_t id) { nodes_.insert(id); }
  void TouchSubmap(std::int64_t id) { submaps_.insert(id); }
  void TouchLoopClosure(std::int64_t id) { closures_.insert(id); }
  // A submap was finished: its row gets its content.
  void AddContent(std::int64_t id) { contents_.insert(id); }
  void Touch(const GraphChange& change);
  void Append(TrajectoryPoint point) { trajectory_.push_back(point); }

  // The rows as they are in `state` now; empties the account.
  SlamDelta Take(const MapperState& state);

 private:
  SlamSubmap RowOf(std::int64_t id, const MapperState& state) const;

  std::set<std::int64_t> nodes_;
  std::set<std::int64_t> submaps_;
  std::set<std::int64_t> closures_;
  std::set<std::int64_t> contents_;
  std::vector<TrajectoryPoint> trajectory_;
};

}  // namespace enfilade::slam
