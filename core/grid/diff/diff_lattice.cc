// SPDX-License-Identifier: Apache-2.0
#include "core/grid/diff/diff_lattice.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/grid/map_raster.h"

namespace enfilade::grid {

absl::Status TooFarApart() {
  return FailedPrecondition(
      "the two maps lie so far apart that one raster around both would have more than {} cells: they cannot be "
      "compared",
      kMaxRasterCells);
}

absl::StatusOr<DiffLattice> LatticeAround(CellIndex a, const GridGeometry& a_size, CellIndex b,
                                          const GridGeometry& b_size) {
  if (a_size.cell_count() == 0) a = b;
  if (b_size.cell_count() == 0) b = a;
  DiffLattice lattice;
  lattice.min = {std::min(a.column, b.column), std::min(a.row, b.row)};
  lattice.max = {std::max({a.column + a_size.width, b.column + b_size.width, lattice.min.column + 1}) - 1,
                 std::max({a.row + a_size.height, b.row + b_size.height, lattice.min.row + 1}) - 1};
  const double columns = static_cast<double>(lattice.max.column) - lattice.min.column + 1;
  const double rows = static_cast<double>(lattice.max.row) - lattice.min.row + 1;
  if (columns * rows > static_cast<double>(kMaxRasterCells)) return TooFarApart();
  return lattice;
}

}  // namespace enfilade::grid
