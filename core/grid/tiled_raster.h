// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <compare>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/grid/files/raster_header.h"
#include "core/grid/map_raster.h"

namespace enfilade::grid {

// A raster in pieces, as it is stored and compared.
//
// Tiles are squares of kTileSize cells on a fixed lattice: tile (row, column) covers the lattice's cells from
// (row, column) * kTileSize on. For a grid made by us the lattice is that of its map's frame (cell (0, 0) begins at the
// map's origin), so that a tile in which nothing has changed keeps its bytes, and its hash, however the map has grown
// around it. An imported raster, and a grid that is rotated or lies between the lattice's lines, has a lattice of its
// own, beginning at its lower-left cell.
//
// A tile's bytes: one byte format version (1), then one Zstandard frame with checksum, of kTileSize^2 values (grey with
// alpha: all greys, then all alphas), rows upwards, cells outside the raster as background. Tiles of background only
// are left out. The background is "unknown" for our grids, the most frequent grey for images, 0.0 for JSON maps. The
// same cells give the same bytes with the same release of libzstd; another may pack them otherwise, but reads them.
constexpr int kTileSize = 256;

// Rows first, so that tiles in order are in the order of the raster.
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

// `raster` is valid.
TiledRaster SplitIntoTiles(const MapRaster& raster);

// Puts a raster together from tiles in any order. Needs the raster's memory once, and one tile's.
class RasterAssembler {
 public:
  // As DecodeRasterHeader.
  static absl::StatusOr<RasterAssembler> Create(std::string_view header);
  RasterAssembler(RasterAssembler&&) noexcept;
  ~RasterAssembler();

  // DATA_LOSS where the bytes are damaged or the tile lies outside the raster, FAILED_PRECONDITION for a newer version.
  absl::Status Add(TileIndex index, std::string_view bytes);
  // Cells of tiles that were not added are background.
  MapRaster Finish() &&;

 private:
  class Impl;
  explicit RasterAssembler(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

absl::StatusOr<MapRaster> JoinTiles(const TiledRaster& tiled);

}  // namespace enfilade::grid
