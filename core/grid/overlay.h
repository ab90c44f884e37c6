// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "core/grid/occupancy_grid.h"

namespace enfilade::grid {

// `grid` with its cells on the lattice of the map's frame: multiples of `resolution` (m), no rotation, cropped to what
// is known. A cell takes the value at its centre; where the given cells are finer or turned, no occupied one is lost. A
// grid that lies so already keeps its cells. INVALID_ARGUMENT where more than kMaxRasterCells would come of it.
absl::StatusOr<OccupancyGrid> OnLattice(const OccupancyGrid& grid, double resolution);

// What two layers say of one cell. Known wins over unknown; where both know it and agree whether it is free or
// occupied, the surer counts; where they disagree, `over`, the later one: things move. Laid over itself a layer stays
// the same.
std::uint8_t LaidOver(std::uint8_t under, std::uint8_t over);

// `over` on `under`, cell by cell. Both lie on the lattice of one resolution, as OnLattice makes them; an empty one (no
// cells) may have any. INVALID_ARGUMENT where they lie so far apart that more than kMaxRasterCells would come of it.
absl::StatusOr<OccupancyGrid> LaidOver(const OccupancyGrid& under, const OccupancyGrid& over);

}  // namespace enfilade::grid
