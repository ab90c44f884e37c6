// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/prior/alignment/map_evidence.h"
#include "core/prior/correction/correct_plan.h"

namespace enfilade::prior {

// A wall that robots have seen and that the plan does not have: its centre line, m, in the map's frame.
struct AddedWall {
  Eigen::Vector2d from = Eigen::Vector2d::Zero();
  Eigen::Vector2d to = Eigen::Vector2d::Zero();
};

// Straight pieces of 1.5 m and more of the map's walls that lie off all walls of the corrected plan and begin or end at
// one across them or in line with them, or at another of them. Two that run beside each other are the faces of one
// wall. What stands free in a room is taken for furniture. Sorted by length, the longest first.
std::vector<AddedWall> FindAddedWalls(const CorrectedPlan& corrected, const MapEvidence& evidence);

}  // namespace enfilade::prior
