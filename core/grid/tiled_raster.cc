// SPDX-License-Identifier: Apache-2.0
#include "core/grid/tiled_raster.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/grid/tile_codec.h"

namespace enfilade::grid {
namespace {

constexpr std::size_t kTileCells = std::size_t{kTileSize} * kTileSize;

int FloorToTile(int cell) { return static_cast<int>(std::floor(static_cast<double>(cell) / kTileSize)); }

// The part of a tile that lies within the raster, in cells.
struct Overlap {
  int column = 0;  // of its lower-left cell in the raster
  int row = 0;
  int tile_column = 0;  // ... and in the tile
  int tile_row = 0;
  int width = 0;
  int height = 0;

  bool empty() const { return width <= 0 || height <= 0; }
};

Overlap OverlapOf(const RasterHeader& header, TileIndex index) {
  const GridGeometry& geometry = header.raster.geometry;
  // The tile's lower-left cell relative to the raster's. 64 bits: far tiles would overflow an int.
  const std::int64_t left = std::int64_t{index.column} * kTileSize - header.lattice_min.column;
  const std::int64_t bottom = std::int64_t{index.row} * kTileSize - header.lattice_min.row;
  Overlap overlap;
  overlap.column = static_cast<int>(std::clamp<std::int64_t>(left, 0, geometry.width));
  overlap.row = static_cast<int>(std::clamp<std::int64_t>(bottom, 0, geometry.height));
  overlap.width = static_cast<int>(std::clamp<std::int64_t>(left + kTileSize, 0, geometry.width)) - overlap.column;
  overlap.height = static_cast<int>(std::clamp<std::int64_t>(bottom + kTileSize, 0, geometry.height)) - overlap.row;
  overlap.tile_column = static_cast<int>(overlap.column - left);
  overlap.tile_row = static_cast<int>(overlap.row - bottom);
  return overlap;
}

// Calls copy(raster bytes, tile bytes, size) for each row of the overlap.
template <typename Byte, typename Copy>
void ForEachRow(const CellPlane<Byte>& plane, const GridGeometry& geometry, const Overlap& overlap, Copy copy) {
  for (int row = 0; row < overlap.height; ++row) {
    const std::size_t in_raster = geometry.index(overlap.column, overlap.row + row);
    const std::size_t in_tile =
        static_cast<std::size_t>(overlap.tile_row + row) * kTileSize + static_cast<std::size_t>(overlap.tile_column);
    copy(plane.bytes + in_raster * plane.element_size, in_tile * plane.element_size,
         static_cast<std::size_t>(overlap.width) * plane.element_size);
  }
}

template <typename Byte>
std::size_t TileBytes(const std::vector<CellPlane<Byte>>& planes) {
  std::size_t size = 0;
  for (const CellPlane<Byte>& plane : planes) size += kTileCells * plane.element_size;
  return size;
}

std::uint8_t MostFrequent(const std::vector<std::uint8_t>& values) {
  std::array<std::array<std::uint32_t, 256>, 4> counts{};  // four, so that a run of one value does not serialise
  for (std::size_t i = 0; i < values.size(); ++i) ++counts[i % 4][values[i]];
  for (std::size_t value = 0; value < 256; ++value) {
    counts[0][value] += counts[1][value] + counts[2][value] + counts[3][value];
  }
  return static_cast<std::uint8_t>(std::max_element(counts[0].begin(), counts[0].end()) - counts[0].begin());
}

// See tiled_raster.h. Sums of whole cells differ from the lattice only by rounding.
CellIndex LatticeMinOf(const GridGeometry& geometry) {
  constexpr double kRounding = 1e-3;
  constexpr double kLimit = 1 << 30;
  const double column = geometry.T_map_grid.x / geometry.resolution;
  const double row = geometry.T_map_grid.y / geometry.resolution;
  if (geometry.T_map_grid.yaw != 0.0 || !(std::abs(column) < kLimit) || !(std::abs(row) < kLimit) ||
      std::abs(column - std::round(column)) > kRounding || std::abs(row - std::round(row)) > kRounding) {
    return {};
  }
  return {static_cast<int>(std::lround(column)), static_cast<int>(std::lround(row))};
}

class TilePacker {
 public:
  // Both must outlive the packer.
  TilePacker(const MapRaster& raster, const RasterHeader& header)
      : header_(header), planes_(PlanesOf(raster, header.background)) {
    background_.resize(TileBytes(planes_));
    std::size_t begin = 0;
    for (const CellPlane<const std::uint8_t>& plane : planes_) {
      const std::size_t size = kTileCells * plane.element_size;
      std::memset(background_.data() + begin, plane.background, size);
      begin += size;
    }
  }

  // Empty if the tile is all background.
  std::string Pack(TileIndex index) {
    const Overlap overlap = OverlapOf(header_, index);
    content_ = background_;
    std::size_t begin = 0;
    for (const CellPlane<const std::uint8_t>& plane : planes_) {
      ForEachRow(plane, header_.raster.geometry, overlap,
                 [&](const std::uint8_t* cells, std::size_t in_tile, std::size_t size) {
                   std::memcpy(content_.data() + begin + in_tile, cells, size);
                 });
      begin += kTileCells * plane.element_size;
    }
    if (content_ == background_) return {};
    return packing_.Pack(content_);
  }

 private:
  const RasterHeader& header_;
  std::vector<CellPlane<const std::uint8_t>> planes_;
  TilePacking packing_;
  std::vector<std::uint8_t> background_;
  std::vector<std::uint8_t> content_;
};

// Allocates all cells as background.
void Allocate(RasterHeader& header) {
  const std::size_t count = header.raster.geometry.cell_count();
  if (auto* const occupancy = std::get_if<OccupancyCells>(&header.raster.cells)) {
    occupancy->values.assign(count, header.background);
  } else if (auto* const unit = std::get_if<UnitCells>(&header.raster.cells)) {
    unit->values.assign(count, 0.0);
  } else {
    auto& grey = std::get<GreyCells>(header.raster.cells);
    grey.grey.assign(count, header.background);
    if (header.has_alpha) grey.alpha.assign(count, 255);
  }
}

}  // namespace

RasterHeader HeaderOf(const MapRaster& raster) {
  RasterHeader header;
  header.raster.geometry = raster.geometry;
  if (std::holds_alternative<OccupancyCells>(raster.cells)) {
    header.lattice_min = LatticeMinOf(raster.geometry);
  } else if (const auto* const unit = std::get_if<UnitCells>(&raster.cells)) {
    header.raster.cells = UnitCells{{}, unit->limits};
  } else {
    const auto& grey = std::get<GreyCells>(raster.cells);
    header.has_alpha = !grey.alpha.empty();
    header.background = MostFrequent(grey.grey);
    header.raster.cells = GreyCells{.max_value = grey.max_value,
                                    .interpretation = grey.interpretation,
                                    .pgm_header = grey.pgm_header,
                                    .pgm_trailer = grey.pgm_trailer};
  }
  return header;
}

TiledRaster SplitIntoTiles(const MapRaster& raster) {
  const RasterHeader header = HeaderOf(raster);
  const GridGeometry& geometry = raster.geometry;
  TiledRaster tiled{EncodeRasterHeader(header), {}};
  TilePacker packer(raster, header);
  const CellIndex min = header.lattice_min;
  for (int row = FloorToTile(min.row); row <= FloorToTile(min.row + geometry.height - 1); ++row) {
    for (int column = FloorToTile(min.column); column <= FloorToTile(min.column + geometry.width - 1); ++column) {
      std::string bytes = packer.Pack({row, column});
      if (!bytes.empty()) tiled.tiles.emplace(TileIndex{row, column}, std::move(bytes));
    }
  }
  return tiled;
}

class RasterAssembler::Impl {
 public:
  explicit Impl(RasterHeader header) : header_(std::move(header)) {
    Allocate(header_);
    planes_ = PlanesOf(header_.raster, header_.background);
    content_.resize(TileBytes(planes_));
  }

  absl::Status Add(TileIndex index, std::string_view bytes) {
    const Overlap overlap = OverlapOf(header_, index);
    if (overlap.empty()) return DataLoss("tile ({}, {}) lies outside the raster", index.row, index.column);
    ENFILADE_RETURN_IF_ERROR(WithContext(packing_.Unpack(bytes, absl::MakeSpan(content_)),
                                         fmt::format("tile ({}, {})", index.row, index.column)));
    std::size_t begin = 0;
    for (const CellPlane<std::uint8_t>& plane : planes_) {
      ForEachRow(plane, header_.raster.geometry, overlap,
                 [&](std::uint8_t* cells, std::size_t in_tile, std::size_t size) {
                   std::memcpy(cells, content_.data() + begin + in_tile, size);
                 });
      begin += kTileCells * plane.element_size;
    }
    return absl::OkStatus();
  }

  MapRaster Finish() { return std::move(header_.raster); }

 private:
  RasterHeader header_;
  TilePacking packing_;
  std::vector<CellPlane<std::uint8_t>> planes_;
  std::vector<std::uint8_t> content_;
};

RasterAssembler::RasterAssembler(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
RasterAssembler::RasterAssembler(RasterAssembler&&) noexcept = default;
RasterAssembler::~RasterAssembler() = default;

absl::StatusOr<RasterAssembler> RasterAssembler::Create(std::string_view header) {
  ENFILADE_ASSIGN_OR_RETURN(RasterHeader decoded, DecodeRasterHeader(header));
  return RasterAssembler(std::make_unique<Impl>(std::move(decoded)));
}

absl::Status RasterAssembler::Add(TileIndex index, std::string_view bytes) { return impl_->Add(index, bytes); }

MapRaster RasterAssembler::Finish() && { return impl_->Finish(); }

}  // namespace enfilade::grid
