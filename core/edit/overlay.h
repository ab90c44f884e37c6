// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "core/edit/map_edit.h"
#include "core/grid/tiled_raster.h"

namespace enfilade::edit {

// One Instruction a cell of a tile, row by row from the lower left: grid::kTileSize^2 bytes.
using TileCells = std::vector<std::uint8_t>;
constexpr std::size_t kCellsOfTile = std::size_t{grid::kTileSize} * grid::kTileSize;

grid::TileIndex TileOf(int column, int row);
// The place of a cell in its tile.
std::size_t PlaceInTile(int column, int row);

// The instructions of a map's cells, as tiles. Tiles without one are left out.
class Overlay {
 public:
  const std::map<grid::TileIndex, TileCells>& tiles() const { return tiles_; }
  bool empty() const { return tiles_.empty(); }
  Instruction At(int column, int row) const;
  // Unset if the tile has no instructions.
  const TileCells* Find(grid::TileIndex index) const;

  // Draws an edit over what is there. `only`: tiles outside of it stay as they are; null: all.
  void Draw(const MapEdit& edit, const std::set<grid::TileIndex>* only = nullptr);
  // One that has no instruction is removed.
  void Set(grid::TileIndex index, TileCells cells);
  void Remove(grid::TileIndex index) { tiles_.erase(index); }

  friend bool operator==(const Overlay&, const Overlay&) = default;

 private:
  std::map<grid::TileIndex, TileCells> tiles_;
};

// Of the tiles that an edit may touch: all, or `most` of them and one more.
std::set<grid::TileIndex> TilesOf(const Shape& shape, std::size_t most = std::numeric_limits<std::size_t>::max() - 1);

// What a draft leaves of published instructions: its own ones lie over them, and kClear takes them away.
TileCells Combine(const TileCells* published, const TileCells* draft);
Overlay Combine(const Overlay& published, const Overlay& draft);

// The SHA-256 of a tile's bytes; null: of a tile without instructions.
std::string DigestOf(const TileCells* cells);

// The bytes of a tile as they are stored (grid::TilePacking).
std::string Pack(const TileCells& cells);
// DATA_LOSS; FAILED_PRECONDITION: a newer format version.
absl::StatusOr<TileCells> UnpackTile(std::string_view bytes);

// Cells that touch one another over sides or corners.
struct Region {
  CellBox box;
  std::int64_t cells = 0;
  int column = 0;  // of the first of them, by row, then column
  int row = 0;
};
// Of the cells with a value other than 0; cells of different values are in different regions. By row, then column.
std::vector<Region> RegionsOf(const Overlay& marks);

// Regions, and which of them each cell is in.
struct RegionMap {
  std::vector<Region> regions;
  // Of each cell of a tile: its region's place in `regions`, from 1; 0: none.
  std::map<grid::TileIndex, std::vector<std::uint32_t>> numbers;
};
RegionMap MapRegions(const Overlay& marks);

}  // namespace enfilade::edit
