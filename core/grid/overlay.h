// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "absl/status/statusor.h"
#include "core/grid/occupancy_grid.h"

namespace enfilade::grid {

// Resamples `grid` to the lattice of the map's frame: no rotation, cell corners at multiples of `resolution` (m),
// cropped to the known cells. Each cell takes the value at its centre; if the source cells are finer or rotated,
// occupied ones are never lost. A grid that is already on the lattice keeps its cells. INVALID_ARGUMENT: the result
// would have more than kMaxRasterCells.
absl::StatusOr<OccupancyGrid> ResampleToLattice(const OccupancyGrid& grid, double resolution);

// One cell of two layers. A known value takes precedence over unknown. If both are free or both occupied, the more
// certain value is taken; if they disagree, `over`, the later one, because things move. Idempotent.
std::uint8_t Overlay(std::uint8_t under, std::uint8_t over);

// Overlays `over` on `under` cell by cell. Both must be on the same lattice (ResampleToLattice); an empty grid may have
// any resolution. INVALID_ARGUMENT: the grids are so far apart that the result would have more than kMaxRasterCells.
absl::StatusOr<OccupancyGrid> Overlay(const OccupancyGrid& under, const OccupancyGrid& over);

// The same for any number of layers, from the lowest up: in one pass, whatever their number.
absl::StatusOr<OccupancyGrid> OverlayAll(std::span<const OccupancyGrid* const> layers);

// Any number of layers as two: overlaying `reset`, then `content` on any grid gives exactly what overlaying the layers
// one by one gives. A cell about which the layers disagree hides what is below it: there `reset` has the least certain
// value that disagrees with `content`. Elsewhere it is unknown.
struct LayerRun {
  OccupancyGrid reset;
  OccupancyGrid content;
};

// The run with `over` on top. Layers as for Overlay; an empty run has empty grids. Errors as Overlay.
absl::StatusOr<LayerRun> Extend(const LayerRun& run, const OccupancyGrid& over);

}  // namespace enfilade::grid
