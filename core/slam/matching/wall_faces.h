// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/geometry/pose2.h"
#include "core/slam/matching/likelihood_field.h"
#include "core/slam/submaps/submap_grid.h"

namespace enfilade::slam {

// A wall has two faces, and a scan shows one of them. A scan that is matched to the other face is off by the wall's
// thickness.

// The points, in the robot's frame, without those within `matched_distance` (m) of a wall that the grid shows only from
// the other side than the robot's: ground behind it, as the robot looks, is free, and none before it is known to be.
std::vector<Eigen::Vector2d> OnFacesSeen(const SubmapGrid& grid, const LikelihoodField& field,
                                         const std::vector<Eigen::Vector2d>& points, const Pose2& T_submap_robot,
                                         double matched_distance);

}  // namespace enfilade::slam
