// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/grid/occupancy_grid.h"
#include "core/rooms/door_candidate.h"
#include "core/rooms/ground.h"

namespace enfilade::rooms {

// m: points of a path that are farther apart are a jump, not a way.
constexpr double kLongestStep = 1.0;

// Where a robot's way is narrower than just before and behind, from wall to wall in the directions of the walls around:
// a door next to furniture is no narrow place of the ground (basins.h), but it is one of the way. `path`: where robots
// have been, map frame, m, in order; points of up to kLongestStep apart are joined. Lines of up to `max_length`, m.
std::vector<DoorCandidate> FindNarrowsOnPath(const GroundMap& ground, const grid::GridGeometry& geometry,
                                             std::span<const Eigen::Vector2d> path, double max_length);

}  // namespace enfilade::rooms
