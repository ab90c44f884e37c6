// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/grid/bresenham.h"
#include "core/grid/map_raster.h"

namespace enfilade::grid {

// A tiled raster without its cells.
struct RasterHeader {
  // With the right kind of cells and their interpretation, but without values.
  MapRaster raster;
  // Whether grey cells have alpha; the empty vector does not say.
  bool has_alpha = false;
  // The position of the raster's lower-left cell on the lattice of tiles.
  CellIndex lattice_min;
  // The value of cells that no tile covers.
  std::uint8_t background = kUnknownCell;
};

// Versioned; the same header gives the same bytes. At most about 130 KiB.
std::string EncodeRasterHeader(const RasterHeader& header);
// DATA_LOSS on bytes that EncodeRasterHeader did not write, FAILED_PRECONDITION on those of a newer version.
absl::StatusOr<RasterHeader> DecodeRasterHeader(std::string_view bytes);

// One array of cells as bytes, for code that is agnostic of their meaning. Byte: std::uint8_t, const or not.
template <typename Byte>
struct CellPlane {
  Byte* bytes;
  std::size_t element_size;
  std::uint8_t background;  // of each byte of an element
};

// The arrays of a raster with cells: one, or grey and alpha.
std::vector<CellPlane<std::uint8_t>> PlanesOf(MapRaster& raster, std::uint8_t background);
std::vector<CellPlane<const std::uint8_t>> PlanesOf(const MapRaster& raster, std::uint8_t background);

}  // namespace enfilade::grid
