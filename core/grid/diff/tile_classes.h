// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "core/grid/raster_header.h"
#include "core/grid/raster_pyramid.h"
#include "core/grid/tile_codec.h"
#include "core/grid/tiled_raster.h"

namespace enfilade::grid {

// CellClass of each cell of an OccupancyGrid, as bytes.
std::array<std::uint8_t, 256> ClassBytesOfCells();

// What the cells of a stored raster are to viewers, tile by tile, by the thresholds of the raster. Not thread-safe.
class TileClasses {
 public:
  // Errors as DecodeRasterHeader.
  static absl::StatusOr<TileClasses> Create(std::string_view header);

  const RasterHeader& header() const { return header_; }
  // Whether tiles that are not stored are unknown throughout.
  bool is_sparse() const { return background_ == CellClass::kUnknown; }

  // The CellClass of each cell of a tile, row by row, the lowest first: kTileSize^2 of them. Without `bytes`: of a tile
  // that is not stored. Cells outside the raster are unknown. Errors as RasterAssembler::Add.
  absl::Status Read(TileIndex index, std::string_view bytes, absl::Span<std::uint8_t> classes);

 private:
  explicit TileClasses(RasterHeader header);
  // Of cells of one byte each.
  absl::Status ReadBytes(TileIndex index, std::string_view bytes, absl::Span<std::uint8_t> classes);
  absl::Status ReadOther(TileIndex index, std::string_view bytes, absl::Span<std::uint8_t> classes) const;

  RasterHeader header_;
  std::array<std::uint8_t, 256> class_of_;  // of a cell of an OccupancyGrid
  bool is_bytes_ = false;                   // a tile has one byte for each cell
  std::array<std::uint8_t, 256> class_of_byte_{};
  CellClass background_ = CellClass::kUnknown;
  TilePacking packing_;
};

}  // namespace enfilade::grid
