// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/grid/occupancy_grid.h"

namespace enfilade::areas {

// Makes the cells unknown that are occupied and have their centres in one of the outlines (m, in the map's frame;
// simple polygons): mirrors and glass show scanners what is not there.
void IgnoreHits(const std::vector<std::vector<Eigen::Vector2d>>& outlines, grid::OccupancyGrid& grid);

}  // namespace enfilade::areas
