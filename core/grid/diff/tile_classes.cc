// SPDX-License-Identifier: Apache-2.0
#include "core/grid/diff/tile_classes.h"

#include <algorithm>
#include <numeric>
#include <string>
#include <utility>
#include <variant>

#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace enfilade::grid {
namespace {

constexpr auto kUnknownClass = static_cast<std::uint8_t>(CellClass::kUnknown);

// A raster that has the cells of one tile only. Also those that lie outside the whole raster.
RasterHeader HeaderOfTile(const RasterHeader& whole, TileIndex index) {
  RasterHeader header = whole;
  header.raster.geometry.width = kTileSize;
  header.raster.geometry.height = kTileSize;
  header.lattice_min = {index.column * kTileSize, index.row * kTileSize};
  return header;
}

absl::StatusOr<MapRaster> AssembleTile(const RasterHeader& whole, TileIndex index, std::string_view bytes) {
  ENFILADE_ASSIGN_OR_RETURN(RasterAssembler assembler,
                            RasterAssembler::Create(EncodeRasterHeader(HeaderOfTile(whole, index))));
  if (!bytes.empty()) ENFILADE_RETURN_IF_ERROR(assembler.Add(index, bytes));
  return std::move(assembler).Finish();
}

// Sets all cells of the tile outside the raster to unknown.
void CutToRaster(const RasterHeader& header, TileIndex index, absl::Span<std::uint8_t> classes) {
  const auto inside = [](int tile, int min, int size) {
    const std::int64_t begin = std::int64_t{min} - std::int64_t{tile} * kTileSize;
    return std::pair{static_cast<int>(std::clamp<std::int64_t>(begin, 0, kTileSize)),
                     static_cast<int>(std::clamp<std::int64_t>(begin + size, 0, kTileSize))};
  };
  const auto [left, right] = inside(index.column, header.lattice_min.column, header.raster.geometry.width);
  const auto [bottom, top] = inside(index.row, header.lattice_min.row, header.raster.geometry.height);
  if (left == 0 && bottom == 0 && right == kTileSize && top == kTileSize) return;
  for (int row = 0; row < kTileSize; ++row) {
    const auto begin = classes.begin() + std::ptrdiff_t{row} * kTileSize;
    const bool is_inside = row >= bottom && row < top;
    std::fill(begin, begin + (is_inside ? left : kTileSize), kUnknownClass);
    if (is_inside) std::fill(begin + right, begin + kTileSize, kUnknownClass);
  }
}

// Of each grey, as the image is read.
std::array<std::uint8_t, 256> ClassBytesOfGreys(const GreyCells& kind, const std::array<std::uint8_t, 256>& class_of) {
  MapRaster scale;
  scale.geometry.width = 256;
  scale.geometry.height = 1;
  GreyCells greys = kind;
  greys.grey.resize(256);
  std::iota(greys.grey.begin(), greys.grey.end(), std::uint8_t{0});
  scale.cells = std::move(greys);
  const OccupancyGrid grid = ToOccupancyGrid(scale);
  std::array<std::uint8_t, 256> classes{};
  std::transform(grid.cells.begin(), grid.cells.end(), classes.begin(),
                 [&](std::uint8_t cell) { return class_of[cell]; });
  return classes;
}

}  // namespace

std::array<std::uint8_t, 256> ClassBytesOfCells() {
  const std::array<CellClass, 256> classes = ClassesOfCells();
  std::array<std::uint8_t, 256> bytes{};
  std::transform(classes.begin(), classes.end(), bytes.begin(),
                 [](CellClass c) { return static_cast<std::uint8_t>(c); });
  return bytes;
}

TileClasses::TileClasses(RasterHeader header) : header_(std::move(header)), class_of_(ClassBytesOfCells()) {
  const auto* const grey = std::get_if<GreyCells>(&header_.raster.cells);
  is_bytes_ = std::holds_alternative<OccupancyCells>(header_.raster.cells) || (grey != nullptr && !header_.has_alpha);
  class_of_byte_ = class_of_;
  if (grey != nullptr && is_bytes_) class_of_byte_ = ClassBytesOfGreys(*grey, class_of_);
}

absl::StatusOr<TileClasses> TileClasses::Create(std::string_view header) {
  ENFILADE_ASSIGN_OR_RETURN(RasterHeader decoded, DecodeRasterHeader(header));
  TileClasses classes(std::move(decoded));
  if (classes.is_bytes_) {
    classes.background_ = static_cast<CellClass>(classes.class_of_byte_[classes.header_.background]);
  } else {
    ENFILADE_ASSIGN_OR_RETURN(const MapRaster background, AssembleTile(classes.header_, {}, {}));
    classes.background_ = static_cast<CellClass>(classes.class_of_[ToOccupancyGrid(background).cells.front()]);
  }
  return classes;
}

absl::Status TileClasses::Read(TileIndex index, std::string_view bytes, absl::Span<std::uint8_t> classes) {
  if (bytes.empty() && is_sparse()) {
    std::fill(classes.begin(), classes.end(), kUnknownClass);
    return absl::OkStatus();
  }
  ENFILADE_RETURN_IF_ERROR(is_bytes_ ? ReadBytes(index, bytes, classes) : ReadOther(index, bytes, classes));
  CutToRaster(header_, index, classes);
  return absl::OkStatus();
}

absl::Status TileClasses::ReadBytes(TileIndex index, std::string_view bytes, absl::Span<std::uint8_t> classes) {
  if (bytes.empty()) {
    std::fill(classes.begin(), classes.end(), static_cast<std::uint8_t>(background_));
    return absl::OkStatus();
  }
  ENFILADE_RETURN_IF_ERROR(
      WithContext(packing_.Unpack(bytes, classes), fmt::format("tile ({}, {})", index.row, index.column)));
  for (std::uint8_t& cell : classes) cell = class_of_byte_[cell];
  return absl::OkStatus();
}

absl::Status TileClasses::ReadOther(TileIndex index, std::string_view bytes, absl::Span<std::uint8_t> classes) const {
  ENFILADE_ASSIGN_OR_RETURN(const MapRaster tile, AssembleTile(header_, index, bytes));
  const OccupancyGrid grid = ToOccupancyGrid(tile);
  std::transform(grid.cells.begin(), grid.cells.end(), classes.begin(), [&](std::uint8_t c) { return class_of_[c]; });
  return absl::OkStatus();
}

}  // namespace enfilade::grid
