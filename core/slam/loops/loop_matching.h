// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/slam/loops/loop_candidates.h"
#include "core/slam/matching/field_pyramid.h"
#include "core/slam/slam_options.h"

namespace enfilade::slam {

// The result of looking for a node in a submap.
struct LoopMatch {
  bool accepted = false;
  Pose2 T_submap_node;
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  // of T_submap_node; zero unless accepted
  double score = 0.0;                                     // share of inliers at the finest level
  std::string reason;                                     // why it was accepted or rejected
};

// Searches the candidate's window about `guess` and refines the result through the pyramid, in the end without hits on
// walls that the submap shows only from the other side (matching/wall_faces.h). Accepts it if the scan fits, few hits
// lie in known free space, the translation is constrained in all directions, and no other place in the window fits
// nearly as well. `hits` in the robot's frame.
LoopMatch MatchLoop(const SearchableSubmap& submap, const std::vector<Eigen::Vector2d>& hits, const Pose2& guess,
                    const LoopCandidate& candidate, const SlamOptions& options);

}  // namespace enfilade::slam
