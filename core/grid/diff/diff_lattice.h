// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/geometry/pose2.h"
#include "core/grid/bresenham.h"
#include "core/grid/occupancy_grid.h"

namespace enfilade::grid {

// The cells that two rasters cover together, on a lattice of theirs.
struct DiffLattice {
  double resolution = 0.0;  // m
  Pose2 T_map_lattice;      // of the lower-left corner of cell (0, 0)
  CellIndex min;
  CellIndex max;

  std::int64_t cell_count() const {
    return (std::int64_t{max.column} - min.column + 1) * (std::int64_t{max.row} - min.row + 1);
  }
};

// The box around two boxes of cells, each given by its lower-left cell and the size of `geometry`. One without cells
// does not count. FAILED_PRECONDITION if it would have more than kMaxRasterCells.
absl::StatusOr<DiffLattice> LatticeAround(CellIndex a, const GridGeometry& a_size, CellIndex b,
                                          const GridGeometry& b_size);

// FAILED_PRECONDITION.
absl::Status TooFarApart();

}  // namespace enfilade::grid
