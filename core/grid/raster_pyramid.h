// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/grid/bresenham.h"
#include "core/grid/occupancy_grid.h"
#include "core/grid/tiled_raster.h"

namespace enfilade::grid {

// What a viewer shows for a cell of an OccupancyGrid. The numbers are in the API.
enum class CellClass : std::uint8_t { kUnknown = 0, kFree = 1, kOccupied = 2 };

// Of each value of a cell, as in exported maps (GreySaveOptions).
std::array<CellClass, 256> ClassesOfCells();

// Smaller and smaller pictures of an occupancy grid, so that walls of one cell can be seen from far away. A cell of
// zoom z stands for 2^z x 2^z cells: the most probable obstacle if one of them is occupied, else the freest if one is
// free, else unknown. Tile (r, c) of zoom z stands for the 2 x 2 tiles (2r..2r+1, 2c..2c+1) of zoom z - 1. The lattice
// is the same at all zooms, so that what lies beneath an unchanged tile's parents alone decides their bytes. It ends
// where the tiles span one row or the two beside the lattice's origin, and the same for columns.
struct RasterPyramid {
  using Level = std::map<TileIndex, std::string>;  // SHA-256 of the tiles' bytes

  std::vector<Level> levels;                // by zoom
  std::map<std::string, std::string> made;  // bytes of tiles by SHA-256: those above zoom 0 that `before` lacks
};

// Gives the bytes of a tile of zoom 0, or of one that `before` has.
using LoadTile = std::function<absl::StatusOr<std::string>(std::string_view sha256)>;

// The pyramid over the tiles of zoom 0. Parents of unchanged tiles are taken from `before`, the levels of an earlier
// pyramid on the same lattice (may be empty). Errors of `load`; as TilePacking::Unpack.
absl::StatusOr<RasterPyramid> BuildPyramid(RasterPyramid::Level tiles, const std::vector<RasterPyramid::Level>& before,
                                           const LoadTile& load);

// A picture of a whole grid.
struct Thumbnail {
  int zoom = 0;
  CellIndex lower_left;  // on the lattice of that zoom
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> classes;  // CellClass, row by row, the lowest first
};
constexpr int kThumbnailSide = 64;

// At most kThumbnailSide cells wide and high, from the pyramid's last level. `lattice_min` is where the grid of
// `width` x `height` cells begins on the lattice.
absl::StatusOr<Thumbnail> MakeThumbnail(const RasterPyramid& pyramid, CellIndex lattice_min, int width, int height,
                                        const LoadTile& load);

}  // namespace enfilade::grid
