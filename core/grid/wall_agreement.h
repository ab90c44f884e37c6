// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "core/grid/occupancy_grid.h"

namespace enfilade::grid {

// How well two grids of one frame go together.
struct WallAgreement {
  // Walls of each grid, in cells, where the other one is known: beside a wall of the other one ...
  std::int64_t matched = 0;
  // ... and in its free ground.
  std::int64_t contradicted = 0;

  // Of all of them; 0 if there are none.
  double contradicted_share() const;
};

// `tolerance`: how far from a wall of the other grid a wall may lie, m. A cell is a wall from a probability of 0.65 on,
// and free up to 0.25 (the thresholds of Nav2's map server).
WallAgreement CompareWalls(const OccupancyGrid& a, const OccupancyGrid& b, double tolerance);

}  // namespace enfilade::grid
