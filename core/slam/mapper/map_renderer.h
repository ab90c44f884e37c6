// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <utility>
#include <vector>

#include "core/grid/occupancy_grid.h"
#include "core/slam/matching/cell_window.h"
#include "core/slam/submaps/known_blocks.h"
#include "core/slam/submaps/submap_grid.h"

namespace enfilade::slam {

// The map's grid as the sum of the submaps' grids. When submaps move, only these are subtracted and added again. The
// sums are of integers at poses rounded to a fraction of a cell, so the same submaps at the same poses give the same
// grid, bit for bit, whatever was placed before. The sum is kept in tiles, and only where a submap has known cells:
// memory grows with the area seen, not with its bounding box.
class MapRenderer {
 public:
  MapRenderer(double resolution, const grid::LogOddsOptions& options);

  // Adds a submap, or moves it. `grid` is called only if the submap must be drawn, and must always return the same grid
  // for the submap. Returns whether it was drawn.
  bool Place(std::int64_t submap, const Pose2& T_map_submap, const std::function<const SubmapGrid&()>& grid);

  // Says where submaps are about to be placed. If most of them have moved, everything placed is taken out at once: then
  // each is drawn once, instead of subtracted and added.
  void Expect(const std::map<std::int64_t, Pose2>& T_map_submaps);

  // The grid of all placed submaps and of `active`, a submap that still changes (may be null), cropped to the known
  // cells. Cell borders lie on multiples of the resolution.
  grid::OccupancyGrid Render(const SubmapGrid* active, const Pose2& T_map_active) const;

  // Bytes of memory held.
  std::size_t bytes() const;

 private:
  struct Cell {
    std::int32_t log_odds = 0;  // the sum over submaps, in LogOddsGrid's units
    std::int32_t known = 0;     // the number of submaps
  };
  // A submap's grid at a pose.
  struct PlacedGrid {
    const SubmapGrid& grid;
    const KnownBlocks& known;
    Pose2 T_submap_map;
    CellWindow window;  // the cells of the map that it can touch
  };
  using TileIndex = std::pair<int, int>;  // row, column
  using Tiles = std::map<TileIndex, std::vector<Cell>>;

  static CellWindow WindowOf(const TileIndex& tile);
  static CellWindow MappedWindow(const SubmapGrid& grid, const Pose2& T_map_submap);
  static CellWindow KnownWindow(const Tiles& tiles);
  // Null: there is no such tile.
  static const Cell* FindCells(const Tiles& tiles, const TileIndex& index);

  Pose2 Rounded(const Pose2& pose) const;
  // `sign` +1 adds the submap's cells to the sums, -1 subtracts them.
  void Add(Tiles& tiles, const SubmapGrid& grid, const Pose2& T_map_submap, int sign) const;
  void AddToTile(Tiles& tiles, const TileIndex& index, const PlacedGrid& placed, int sign) const;
  void DrawTile(const TileIndex& index, const Tiles& placed, const Tiles& active, grid::OccupancyGrid& grid) const;

  double resolution_;
  std::int32_t lowest_;  // sums of log-odds beyond these are as certain
  std::int32_t highest_;
  std::vector<std::uint8_t> cell_of_;  // by the sum of log-odds, from `lowest_` on
  std::map<std::int64_t, Pose2> placed_;
  CellWindow window_;  // of all submaps ever placed
  Tiles tiles_;
};

}  // namespace enfilade::slam
