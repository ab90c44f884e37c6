// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <utility>
#include <vector>

#include "core/grid/occupancy_grid.h"
#include "core/slam/matching/cell_window.h"
#include "core/slam/submaps/submap_grid.h"

namespace enfilade::slam {

// The map's grid as the sum of the finished submaps' grids, kept up to date by taking out and putting in only the
// submaps that moved. Sums of whole numbers at poses rounded to a fraction of a cell: however the sum came about, the
// same submaps at the same poses give the same grid, bit for bit. The sum is kept in tiles, of those places only that
// a submap knows: a long way across a campus costs what was seen of it.
class MapRenderer {
 public:
  MapRenderer(double resolution, const grid::LogOddsOptions& options);

  // Puts a submap in, or moves it. `grid` is called only where something is to be drawn, and must always give the
  // submap's same grid. Returns whether anything was drawn.
  bool Place(std::int64_t submap, const Pose2& T_map_submap, const std::function<const SubmapGrid&()>& grid);

  // The grid of all that was placed, and of `active`, a submap that still changes (may be null), cropped to what is
  // known. Cells of the map lie on multiples of the resolution.
  grid::OccupancyGrid Render(const SubmapGrid* active, const Pose2& T_map_active) const;

  // Bytes of memory held.
  std::size_t bytes() const;

 private:
  struct Cell {
    std::int32_t log_odds = 0;  // the sum over submaps, in LogOddsGrid's units
    std::int32_t known = 0;     // the number of submaps
  };
  using TileIndex = std::pair<int, int>;  // row, column
  using Tiles = std::map<TileIndex, std::vector<Cell>>;

  static CellWindow WindowOf(const TileIndex& tile);
  static CellWindow MappedWindow(const SubmapGrid& grid, const Pose2& T_map_submap);
  static CellWindow KnownWindow(const Tiles& tiles);

  Pose2 Rounded(const Pose2& pose) const;
  void Add(Tiles& tiles, const SubmapGrid& grid, const Pose2& T_map_submap, int sign) const;
  void AddToTile(Tiles& tiles, const TileIndex& index, const CellWindow& mapped, const SubmapGrid& grid,
                 const Pose2& T_submap_map, int sign) const;
  void DrawTile(const TileIndex& index, const Tiles& placed, const Tiles& active, grid::OccupancyGrid& grid) const;

  double resolution_;
  double min_log_odds_;
  double max_log_odds_;
  std::map<std::int64_t, Pose2> placed_;
  CellWindow window_;  // of all that was ever placed
  Tiles tiles_;
};

}  // namespace enfilade::slam
