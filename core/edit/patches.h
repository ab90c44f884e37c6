// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "absl/status/statusor.h"
#include "core/edit/map_edit.h"
#include "core/edit/overlay.h"
#include "core/grid/raster_pyramid.h"

namespace enfilade::edit {

// Cells as patches. What an edit covers may depend on what the map shows when it is made ("fill", "only where free"):
// it becomes a patch then, so that it stays the same whatever is mapped or undone later.

// The marked cells (other than 0) within `box`.
Patch PatchOf(const Overlay& marks, const CellBox& box);

// The cells of a region, by its place in the map's regions.
Patch CellsOf(const RegionMap& map, std::size_t region);

// What a cell shows; asked for cells within the map only.
using ClassAt = std::function<grid::CellClass(int column, int row)>;

// Those of the shape's cells within `map` that show one of the classes. INVALID_ARGUMENT if there are none.
absl::StatusOr<Patch> CellsWhere(const Shape& shape, const std::vector<grid::CellClass>& classes, const CellBox& map,
                                 const ClassAt& class_at);

// The cells within `bounds` and `map` that show the class of the seed's cell and are joined to it over their sides.
// INVALID_ARGUMENT if the seed is outside, or there are more than kMaxCells.
absl::StatusOr<Patch> FilledCells(LatticePoint seed, const CellBox& bounds, const CellBox& map,
                                  const ClassAt& class_at);

}  // namespace enfilade::edit
