// SPDX-License-Identifier: Apache-2.0
#include "core/slam/slam_map.h"

#include <utility>

namespace enfilade::slam {

void SlamMap::Apply(SlamDelta delta) {
  for (SlamNode& node : delta.nodes) nodes[node.id] = std::move(node);
  for (SlamSubmap& submap : delta.submaps) {
    SlamSubmap& stored = submaps[submap.id];
    if (submap.content.empty()) submap.content = std::move(stored.content);
    stored = std::move(submap);
  }
  for (LoopClosure& closure : delta.loop_closures) loop_closures[closure.id] = std::move(closure);
  trajectory.insert(trajectory.end(), delta.trajectory.begin(), delta.trajectory.end());
}

std::vector<StampedPose> TrajectoryOf(const std::map<std::int64_t, SlamNode>& nodes,
                                      const std::vector<TrajectoryPoint>& trajectory) {
  std::vector<StampedPose> poses;
  poses.reserve(trajectory.size());
  for (const TrajectoryPoint& point : trajectory) {
    poses.push_back({point.time, nodes.at(point.node).T_map_node * point.T_node_robot});
  }
  return poses;
}

std::vector<StampedPose> TrajectoryOf(const SlamMap& map) { return TrajectoryOf(map.nodes, map.trajectory); }

}  // namespace enfilade::slam
