// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <random>
#include <string>
#include <vector>

#include "core/edit/overlay.h"
#include "core/grid/map_raster.h"

namespace enfilade::edit {

// Small rasters with random cells in every form that a map may have: modes, dialects, negation, thresholds, alpha,
// several whites, JSON, and our own.
std::vector<grid::MapRaster> EveryForm(std::mt19937& random);
std::string NameOf(const grid::MapRaster& form);

// The raster's cells under the overlay read back as what it says, and all others are as before, to the byte. `min`: the
// raster's lower-left cell.
void ExpectExactlyApplied(const grid::MapRaster& before, const grid::MapRaster& after, const Overlay& overlay,
                          grid::CellIndex min);

}  // namespace enfilade::edit
