// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "core/edit/map_edit.h"
#include "core/edit/overlay.h"
#include "core/grid/map_raster.h"
#include "core/grid/raster_header.h"
#include "core/grid/raster_pyramid.h"

namespace enfilade::edit {

// The lattice of a raster's tiles (grid::TiledRaster), on which it is edited, and where the raster lies on it.
Lattice LatticeOf(const grid::RasterHeader& header);
CellBox BoxOf(const grid::RasterHeader& header);

// FAILED_PRECONDITION if no value of the raster's form reads back as what the instruction says: a PGM in mode "scale"
// has no "unknown", nor has JSON. Needs no cells.
absl::Status CanSay(const grid::RasterHeader& header, Instruction instruction);

// Writes the instructions into cells of the raster, whose lower-left cell is `min` on the lattice; those outside are
// left out. Cells become certainly free, certainly occupied or unknown: of images the grey that reads back as that by
// their own mode, thresholds and dialect. All other cells keep their bytes. Errors as CanSay, before anything is
// changed.
absl::Status Apply(const Overlay& overlay, grid::CellIndex min, grid::MapRaster& raster);

// What viewers show of each cell (grid::ClassesOfCells), row by row from the lower left.
std::vector<grid::CellClass> ClassesOf(const grid::MapRaster& raster);

}  // namespace enfilade::edit
