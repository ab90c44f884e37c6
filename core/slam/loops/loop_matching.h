// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/slam/loops/loop_candidates.h"
#include "core/slam/matching/field_pyramid.h"
#include "core/slam/slam_options.h"
#include "core/slam/submaps/submap_grid.h"

namespace enfilade::slam {

// What came of looking for a node in a submap.
struct LoopMatch {
  bool accepted = false;
  Pose2 T_submap_node;
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  // of T_submap_node
  double score = 0.0;                                     // share of inliers at the finest level
  std::string reason;
};

// Searches the candidate's window about `guess`, refines what it finds through the pyramid, and accepts it where the
// scan fits, little of it lies in space that the submap knows to be free, the match says where the robot is in all
// directions, and no other place in the window fits nearly as well. `hits` in the robot's frame.
LoopMatch MatchLoop(const SubmapGrid& grid, const FieldPyramid& pyramid, const std::vector<Eigen::Vector2d>& hits,
                    const Pose2& guess, const LoopCandidate& candidate, const SlamOptions& options);

}  // namespace enfilade::slam
