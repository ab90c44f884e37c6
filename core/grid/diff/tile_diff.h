// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "core/grid/diff/map_diff.h"
#include "core/grid/raster_header.h"

namespace enfilade::grid {

// Whether tile (0, 0) of one raster lies on that of the other.
bool HaveSameTiles(const RasterHeader& a, const RasterHeader& b);

// DiffTiles of two rasters that have the same tiles.
absl::StatusOr<MapDiff> DiffTileByTile(const StoredTiles& base, const StoredTiles& revision, const LoadTiles& load,
                                       const MapDiffOptions& options);

}  // namespace enfilade::grid
