// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/geometry/pose2.h"
#include "core/slam/slam_map.h"
#include "core/slam/state/mapper_state.h"

namespace enfilade::testing {

struct SubmapChain {
  int submaps = 5;  // all finished, without content; ids from 0
  Pose2 T_submap_next = {10.0, 0.0, 0.0};
  double length = 10.0;     // m driven in each
  double sigma = 0.05;      // m, of each step to the next submap
  double yaw_sigma = 0.02;  // rad
};

// A mapper's state after a drive along a chain of submaps. Each has one keyframe of its own, with the submap's id, at
// (1, 0, 0) of it.
slam::MapperState MakeSubmapChain(const SubmapChain& chain);

// Node `node` accepted in `submap` at `T_submap_node`, known to 5 cm and 0.01 rad.
slam::LoopClosure MakeLoopClosure(std::int64_t id, std::int64_t submap, std::int64_t node, const Pose2& T_submap_node);

}  // namespace enfilade::testing
