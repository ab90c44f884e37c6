// SPDX-License-Identifier: Apache-2.0
#include "tests/unit/core/slam/chain_of_submaps.h"

#include <optional>
#include <vector>

#include "core/slam/matching/motion_model.h"
#include "core/slam/submaps/finished_submap.h"

namespace enfilade::testing {

slam::MapperState MakeSubmapChain(const SubmapChain& chain) {
  slam::MapperState state;
  Pose2 pose;
  for (std::int64_t id = 0; id < chain.submaps; ++id) {
    const std::vector<slam::SubmapNode> nodes{
        {id, false, chain.length, {1.0, 0.0, 0.0}, slam::InformationOf(0.01, 0.002)}};
    std::optional<slam::NextSubmap> next;
    if (id + 1 < chain.submaps) {
      next = slam::NextSubmap{chain.T_submap_next, slam::InformationOf(chain.sigma, chain.yaw_sigma)};
    }
    state.finished[id] = slam::FinishSubmap(pose, 1, "", nodes, next);
    slam::SlamNode node;
    node.id = id;
    node.sequence = 10 * id;
    node.T_map_node = pose * nodes[0].T_submap_node;
    node.submap = id;
    state.nodes[id] = node;
    pose = pose * chain.T_submap_next;
  }
  return state;
}

slam::LoopClosure MakeLoopClosure(std::int64_t id, std::int64_t submap, std::int64_t node, const Pose2& T_submap_node) {
  slam::LoopClosure closure;
  closure.id = id;
  closure.submap = submap;
  closure.node = node;
  closure.T_submap_node = T_submap_node;
  closure.information = slam::InformationOf(0.05, 0.01);
  closure.state = slam::LoopClosureState::kAccepted;
  return closure;
}

}  // namespace enfilade::testing
