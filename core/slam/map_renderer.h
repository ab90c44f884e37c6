#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <vector>

#include "core/grid/occupancy_grid.h"
#include "core/slam/submap_grid.h"

namespace enfilade {

// The map's grid as the sum of the finished submaps' grids, kept up to date by taking out and putting in only the
// submaps that moved. Sums of whole numbers at poses rounded to a fraction of a cell: however the sum came about, the
// same submaps at the same poses give the same grid, bit for bit.
class MapRenderer {
 public:
  MapRenderer(double resolution, const LogOddsOptions& options);

  // Puts a submap in, or moves it. `grid` is called only where something is to be drawn, and must always give the
  // submap's same grid. Returns whether anything was drawn.
  bool Place(std::int64_t submap, const Pose2& T_map_submap, const std::function<const SubmapGrid&()>& grid);

  // The grid of all that was placed, and of `active`, a submap that still changes (may be null), cropped to what is
  // known. Cells of the map lie on multiples of the resolution.
  OccupancyGrid Render(const SubmapGrid* active, const Pose2& T_map_active) const;

 private:
  struct Window {
    CellIndex min;
    int width = 0;
    int height = 0;

    bool empty() const { return width == 0; }
    std::size_t cell_count() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
    std::size_t index(int column, int row) const {
      return static_cast<std::size_t>(row - min.row) * static_cast<std::size_t>(width) +
             static_cast<std::size_t>(column - min.column);
    }
  };
  struct Cell {
    std::int32_t log_odds = 0;  // the sum over submaps, in LogOddsGrid's units
    std::int32_t known = 0;     // the number of submaps
  };
  struct Raster {
    Window window;
    std::vector<Cell> cells;
  };

  static Window MappedWindow(const SubmapGrid& grid, const Pose2& T_map_submap);
  static bool Cover(Raster& raster, const Window& needed);
  static Window KnownWindow(const Raster& raster);

  Pose2 Rounded(const Pose2& pose) const;
  void Add(Raster& raster, const SubmapGrid& grid, const Pose2& T_map_submap, int sign) const;

  double resolution_;
  double min_log_odds_;
  double max_log_odds_;
  std::map<std::int64_t, Pose2> placed_;
  Raster raster_;
};

}  // namespace enfilade
