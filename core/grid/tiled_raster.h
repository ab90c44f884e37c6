// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <compare>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/grid/map_raster.h"
#include "core/grid/raster_header.h"

namespace enfilade::grid {

// A raster as tiles, the form in which it is stored and compared.
//
// Tiles are squares of kTileSize cells on a fixed lattice: tile (row, column) covers the lattice's cells from
// (row, column) * kTileSize on. For a grid made by this program the lattice is that of the map's frame (cell (0, 0)
// starts at the map's origin): an unchanged tile keeps its bytes, and so its hash, however the map grows around it. An
// imported raster, and a grid that is rotated or off the lattice, has its own lattice, which starts at its lower-left
// cell.
//
// A tile's bytes: one byte format version (1), then one Zstandard frame with checksum, of kTileSize^2 values (grey with
// alpha: all greys, then all alphas), rows upwards, cells outside the raster as background. Tiles that are all
// background are omitted. The background is "unknown" for occupancy grids, the most frequent grey for images, 0.0 for
// JSON maps. The same cells give the same bytes with the same release of libzstd; another release may compress
// differently but reads them.
constexpr int kTileSize = 256;

// Ordered by row, then column: the order of the raster.
struct TileIndex {
  int row = 0;
  int column = 0;

  friend auto operator<=>(const TileIndex&, const TileIndex&) = default;
};

struct TiledRaster {
  std::string header;  // EncodeRasterHeader
  std::map<TileIndex, std::string> tiles;

  friend bool operator==(const TiledRaster&, const TiledRaster&) = default;
};

// Without cells. `raster` must be valid.
RasterHeader HeaderOf(const MapRaster& raster);
// `raster` must be valid.
TiledRaster SplitIntoTiles(const MapRaster& raster);

// Assembles a raster from tiles in any order. Needs memory for the raster and one tile.
class RasterAssembler {
 public:
  // Errors as DecodeRasterHeader.
  static absl::StatusOr<RasterAssembler> Create(std::string_view header);
  RasterAssembler(RasterAssembler&&) noexcept;
  ~RasterAssembler();

  // DATA_LOSS: damaged bytes, or a tile outside the raster. FAILED_PRECONDITION: a newer format version.
  absl::Status Add(TileIndex index, std::string_view bytes);
  // Tiles that were not added are background.
  MapRaster Finish() &&;

 private:
  class Impl;
  explicit RasterAssembler(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace enfilade::grid
