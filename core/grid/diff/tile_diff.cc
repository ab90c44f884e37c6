// SPDX-License-Identifier: Apache-2.0
#include "core/grid/diff/tile_diff.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>
#include <variant>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/grid/diff/diff_sweep.h"
#include "core/grid/diff/tile_classes.h"
#include "core/grid/tiled_raster.h"

namespace enfilade::grid {
namespace {

constexpr std::size_t kTilesAtOnce = 128;
constexpr std::size_t kCellsOfDiffTile = std::size_t{kTileSize} * kTileSize;
constexpr double kOffTiles = 1e-3;  // cells

Pose2 PoseOfTiles(const RasterHeader& header) {
  const GridGeometry& geometry = header.raster.geometry;
  return geometry.T_map_grid *
         Pose2{-header.lattice_min.column * geometry.resolution, -header.lattice_min.row * geometry.resolution, 0.0};
}

// Two rasters whose tiles lie on one another.
class TileDiff {
 public:
  TileDiff(const StoredTiles& base, TileClasses base_classes, const StoredTiles& revision, TileClasses classes)
      : sides_{Side{base, std::move(base_classes), std::vector<std::uint8_t>(kCellsOfDiffTile)},
               Side{revision, std::move(classes), std::vector<std::uint8_t>(kCellsOfDiffTile)}} {
    const bool are_cells = std::all_of(sides_.begin(), sides_.end(), [](const Side& side) {
      return std::holds_alternative<OccupancyCells>(side.classes.header().raster.cells);
    });
    equal_bytes_mean_equal_cells_ = are_cells || base.header == revision.header;
  }

  absl::StatusOr<MapDiff> Run(const LoadTiles& load, const MapDiffOptions& options) {
    const RasterHeader& a = sides_[0].classes.header();
    const RasterHeader& b = sides_[1].classes.header();
    ENFILADE_ASSIGN_OR_RETURN(DiffLattice lattice,
                              LatticeAround(a.lattice_min, a.raster.geometry, b.lattice_min, b.raster.geometry));
    lattice.resolution = b.raster.geometry.resolution;
    lattice.T_map_lattice = PoseOfTiles(b);
    DiffSweep sweep(lattice, options);
    const std::set<TileIndex> known = KnownTiles();
    const std::vector<TileIndex> tiles(known.begin(), known.end());
    for (std::size_t begin = 0; begin < tiles.size(); begin += kTilesAtOnce) {
      const std::size_t end = std::min(tiles.size(), begin + kTilesAtOnce);
      const absl::Span<const TileIndex> portion(&tiles[begin], end - begin);
      ENFILADE_ASSIGN_OR_RETURN(const auto bytes, load(DigestsOf(portion)));
      for (const TileIndex index : portion) ENFILADE_RETURN_IF_ERROR(Compare(index, bytes, sweep));
    }
    return std::move(sweep).Finish();
  }

 private:
  using Bytes = std::map<std::string, std::string>;  // by digest
  struct Side {
    const StoredTiles& tiles;
    TileClasses classes;
    std::vector<std::uint8_t> cells;  // of the current tile

    // Empty if it is not stored.
    std::string_view DigestOf(TileIndex index) const {
      const auto found = tiles.tiles.find(index);
      return found == tiles.tiles.end() ? std::string_view() : std::string_view(found->second);
    }
  };

  // All in which one of the rasters may have known cells.
  std::set<TileIndex> KnownTiles() const {
    std::set<TileIndex> known;
    for (const Side& side : sides_) {
      for (const auto& [index, sha256] : side.tiles.tiles) known.insert(index);
      if (side.classes.is_sparse()) continue;
      const CellIndex min = side.classes.header().lattice_min;
      const GridGeometry& geometry = side.classes.header().raster.geometry;
      for (int row = TileOf(min.row); row <= TileOf(min.row + geometry.height - 1); ++row) {
        for (int column = TileOf(min.column); column <= TileOf(min.column + geometry.width - 1); ++column) {
          known.insert({row, column});
        }
      }
    }
    return known;
  }
  static int TileOf(int cell) { return cell >> 8; }  // also of negative ones
  static_assert(kTileSize == 1 << 8);

  std::vector<std::string> DigestsOf(absl::Span<const TileIndex> portion) const {
    std::set<std::string> digests;
    for (const TileIndex index : portion) {
      for (const Side& side : sides_) {
        if (!side.DigestOf(index).empty()) digests.emplace(side.DigestOf(index));
      }
    }
    return {digests.begin(), digests.end()};
  }

  absl::Status Read(Side& side, TileIndex index, const Bytes& bytes) const {
    const std::string digest(side.DigestOf(index));
    const auto found = bytes.find(digest);
    if (!digest.empty() && found == bytes.end()) {
      return DataLoss("tile ({}, {}) of a revision is not stored", index.row, index.column);
    }
    return side.classes.Read(index, digest.empty() ? std::string_view() : found->second, absl::MakeSpan(side.cells));
  }

  absl::Status Compare(TileIndex index, const Bytes& bytes, DiffSweep& sweep) {
    auto& [base, revision] = sides_;
    const bool is_same = equal_bytes_mean_equal_cells_ && base.DigestOf(index) == revision.DigestOf(index);
    ENFILADE_RETURN_IF_ERROR(Read(revision, index, bytes));
    if (!is_same) ENFILADE_RETURN_IF_ERROR(Read(base, index, bytes));
    const std::uint8_t* const before = is_same ? revision.cells.data() : base.cells.data();
    for (int row = 0; row < kTileSize; ++row) {
      const std::ptrdiff_t begin = std::ptrdiff_t{row} * kTileSize;
      ENFILADE_RETURN_IF_ERROR(sweep.Add(index.row * kTileSize + row, index.column * kTileSize, before + begin,
                                         revision.cells.data() + begin, kTileSize));
    }
    return absl::OkStatus();
  }

  std::array<Side, 2> sides_;
  bool equal_bytes_mean_equal_cells_ = false;
};

}  // namespace

bool HaveSameTiles(const RasterHeader& a, const RasterHeader& b) {
  const Pose2 pose_a = PoseOfTiles(a);
  const Pose2 pose_b = PoseOfTiles(b);
  const double resolution = a.raster.geometry.resolution;
  return resolution == b.raster.geometry.resolution && pose_a.yaw == pose_b.yaw &&
         std::abs(pose_a.x - pose_b.x) < kOffTiles * resolution &&
         std::abs(pose_a.y - pose_b.y) < kOffTiles * resolution;
}

absl::StatusOr<MapDiff> DiffTileByTile(const StoredTiles& base, const StoredTiles& revision, const LoadTiles& load,
                                       const MapDiffOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(TileClasses base_classes, TileClasses::Create(base.header));
  ENFILADE_ASSIGN_OR_RETURN(TileClasses classes, TileClasses::Create(revision.header));
  return TileDiff(base, std::move(base_classes), revision, std::move(classes)).Run(load, options);
}

}  // namespace enfilade::grid
