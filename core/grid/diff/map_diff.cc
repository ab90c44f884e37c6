// SPDX-License-Identifier: Apache-2.0
#include "core/grid/diff/map_diff.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/grid/diff/diff_sweep.h"
#include "core/grid/diff/tile_classes.h"
#include "core/grid/diff/tile_diff.h"
#include "core/grid/overlay.h"
#include "core/grid/raster_header.h"
#include "core/grid/tiled_raster.h"

namespace enfilade::grid {
namespace {

constexpr std::size_t kAssembledAtOnce = 128;  // tiles
constexpr double kOffCells = 1e-3;
constexpr double kFarthest = 1 << 29;  // cells

absl::StatusOr<MapRaster> Assemble(const StoredTiles& stored, const LoadTiles& load) {
  ENFILADE_ASSIGN_OR_RETURN(RasterAssembler assembler, RasterAssembler::Create(stored.header));
  for (auto tile = stored.tiles.begin(); tile != stored.tiles.end();) {
    const auto begin = tile;
    std::set<std::string> digests;
    for (std::size_t i = 0; i < kAssembledAtOnce && tile != stored.tiles.end(); ++i, ++tile)
      digests.insert(tile->second);
    ENFILADE_ASSIGN_OR_RETURN(const auto bytes, load({digests.begin(), digests.end()}));
    for (auto one = begin; one != tile; ++one) {
      const auto found = bytes.find(one->second);
      if (found == bytes.end()) {
        return DataLoss("tile ({}, {}) of a revision is not stored", one->first.row, one->first.column);
      }
      ENFILADE_RETURN_IF_ERROR(assembler.Add(one->first, found->second));
    }
  }
  return std::move(assembler).Finish();
}

// A grid on a lattice that it shares with another one.
struct PlacedGrid {
  OccupancyGrid grid;
  CellIndex min;

  // Writes its classes of a row of the lattice, of which `row[0]` is the column `left`. False if it has no such row.
  bool CopyRow(int lattice_row, int left, const std::array<std::uint8_t, 256>& class_of,
               std::vector<std::uint8_t>& row) const {
    const int own_row = lattice_row - min.row;
    std::fill(row.begin(), row.end(), static_cast<std::uint8_t>(CellClass::kUnknown));
    if (own_row < 0 || own_row >= grid.geometry.height) return false;
    const auto cells = grid.cells.begin() + static_cast<std::ptrdiff_t>(grid.geometry.index(0, own_row));
    std::transform(cells, cells + grid.geometry.width, row.begin() + (min.column - left),
                   [&](std::uint8_t cell) { return class_of[cell]; });
    return true;
  }
};

absl::StatusOr<MapDiff> DiffPlaced(const PlacedGrid& base, const PlacedGrid& revision, const Pose2& T_map_lattice,
                                   const MapDiffOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(DiffLattice lattice,
                            LatticeAround(base.min, base.grid.geometry, revision.min, revision.grid.geometry));
  lattice.resolution = revision.grid.geometry.resolution;
  lattice.T_map_lattice = T_map_lattice;
  DiffSweep sweep(lattice, options);
  const std::array<std::uint8_t, 256> class_of = ClassBytesOfCells();
  const int width = lattice.max.column - lattice.min.column + 1;
  std::vector<std::uint8_t> before(static_cast<std::size_t>(width)), after(before);
  for (int row = lattice.min.row; row <= lattice.max.row; ++row) {
    const bool was_there = base.CopyRow(row, lattice.min.column, class_of, before);
    const bool is_there = revision.CopyRow(row, lattice.min.column, class_of, after);
    if (!was_there && !is_there) continue;
    ENFILADE_RETURN_IF_ERROR(sweep.Add(row, lattice.min.column, before.data(), after.data(), width));
  }
  return std::move(sweep).Finish();
}

// Where `revision` begins among the cells of `base`, if its cells lie on those.
absl::StatusOr<std::optional<CellIndex>> OffsetInCells(const GridGeometry& base, const GridGeometry& revision) {
  if (base.resolution != revision.resolution || base.T_map_grid.yaw != revision.T_map_grid.yaw) return std::nullopt;
  const Pose2 T_base_revision = Inverse(base.T_map_grid) * revision.T_map_grid;
  const double column = T_base_revision.x / base.resolution;
  const double row = T_base_revision.y / base.resolution;
  if (!(std::abs(column) < kFarthest) || !(std::abs(row) < kFarthest)) return TooFarApart();
  if (std::abs(column - std::round(column)) > kOffCells || std::abs(row - std::round(row)) > kOffCells) {
    return std::nullopt;
  }
  return CellIndex{static_cast<int>(std::lround(column)), static_cast<int>(std::lround(row))};
}

absl::StatusOr<PlacedGrid> Resample(const OccupancyGrid& grid, double resolution) {
  absl::StatusOr<OccupancyGrid> resampled = ResampleToLattice(grid, resolution);
  if (!resampled.ok()) return FailedPrecondition("{}", std::string(resampled.status().message()));
  const Pose2 origin = resampled->geometry.T_map_grid;
  return PlacedGrid{
      *std::move(resampled),
      {static_cast<int>(std::lround(origin.x / resolution)), static_cast<int>(std::lround(origin.y / resolution))}};
}

}  // namespace

std::int64_t MapDiff::changed_cells() const {
  return std::accumulate(cells.begin(), cells.end(), std::int64_t{0}) - cells[0] - cells[4] - cells[8];
}

absl::StatusOr<MapDiff> DiffTiles(const StoredTiles& base, const StoredTiles& revision, const LoadTiles& load,
                                  const MapDiffOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(const RasterHeader base_header, DecodeRasterHeader(base.header));
  ENFILADE_ASSIGN_OR_RETURN(const RasterHeader header, DecodeRasterHeader(revision.header));
  if (HaveSameTiles(base_header, header)) return DiffTileByTile(base, revision, load, options);
  ENFILADE_ASSIGN_OR_RETURN(const MapRaster before, Assemble(base, load));
  ENFILADE_ASSIGN_OR_RETURN(const MapRaster after, Assemble(revision, load));
  return DiffRasters(before, after, options);
}

absl::StatusOr<MapDiff> DiffRasters(const MapRaster& base, const MapRaster& revision, const MapDiffOptions& options) {
  PlacedGrid before{ToOccupancyGrid(base), {}};
  PlacedGrid after{ToOccupancyGrid(revision), {}};
  ENFILADE_ASSIGN_OR_RETURN(const std::optional<CellIndex> offset, OffsetInCells(base.geometry, revision.geometry));
  if (offset) {
    after.min = *offset;
    return DiffPlaced(before, after, base.geometry.T_map_grid, options);
  }
  const double resolution = std::max(base.geometry.resolution, revision.geometry.resolution);
  ENFILADE_ASSIGN_OR_RETURN(before, Resample(before.grid, resolution));
  ENFILADE_ASSIGN_OR_RETURN(after, Resample(after.grid, resolution));
  return DiffPlaced(before, after, Pose2{}, options);
}

}  // namespace enfilade::grid
