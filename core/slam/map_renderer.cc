#include "core/slam/map_renderer.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace enfilade {
namespace {

// A map of more cells than this (800 m x 800 m at 5 cm) is not drawn as one raster: what lies outside is left out.
constexpr double kMaxCells = 1 << 28;
constexpr int kBlock = 256;
constexpr double kPositionStep = 1.0 / 8.0;  // of a cell
constexpr double kYawStep = 5e-4;            // rad

int FloorToBlock(int v) { return static_cast<int>(std::floor(static_cast<double>(v) / kBlock)) * kBlock; }

double LogOdds(double p) { return std::log(p / (1.0 - p)); }

}  // namespace

MapRenderer::MapRenderer(double resolution, const LogOddsOptions& options)
    : resolution_(resolution), min_log_odds_(LogOdds(options.p_min)), max_log_odds_(LogOdds(options.p_max)) {}

bool MapRenderer::Place(std::int64_t submap, const Pose2& T_map_submap,
                        const std::function<const SubmapGrid&()>& grid) {
  const Pose2 rounded = Rounded(T_map_submap);
  const auto placed = placed_.find(submap);
  if (placed != placed_.end() && placed->second == rounded) return false;
  const SubmapGrid& drawn = grid();
  if (placed != placed_.end()) Add(raster_, drawn, placed->second, -1);
  Add(raster_, drawn, rounded, +1);
  placed_[submap] = rounded;
  return true;
}

OccupancyGrid MapRenderer::Render(const SubmapGrid* active, const Pose2& T_map_active) const {
  Raster copy;
  if (active) {
    copy = raster_;
    Add(copy, *active, Rounded(T_map_active), +1);
  }
  const Raster& raster = active ? copy : raster_;
  const Window known = KnownWindow(raster);
  OccupancyGrid grid;
  grid.geometry.resolution = resolution_;
  if (known.empty()) return grid;
  grid.geometry.width = known.width;
  grid.geometry.height = known.height;
  grid.geometry.T_map_grid = {known.min.column * resolution_, known.min.row * resolution_, 0.0};
  grid.cells.assign(grid.geometry.cell_count(), kUnknownCell);
  for (int row = 0; row < known.height; ++row) {
    for (int column = 0; column < known.width; ++column) {
      const Cell& cell = raster.cells[raster.window.index(known.min.column + column, known.min.row + row)];
      if (cell.known == 0) continue;
      const double log_odds = std::clamp(cell.log_odds / LogOddsGrid::kUnitsPerLogOdds, min_log_odds_, max_log_odds_);
      grid.cells[grid.geometry.index(column, row)] = CellFromProbability(1.0 / (1.0 + std::exp(-log_odds)));
    }
  }
  return grid;
}

Pose2 MapRenderer::Rounded(const Pose2& pose) const {
  const double step = resolution_ * kPositionStep;
  return {std::round(pose.x / step) * step, std::round(pose.y / step) * step,
          std::round(pose.yaw / kYawStep) * kYawStep};
}

// The cells of the map that the grid at `T_map_submap` can touch.
MapRenderer::Window MapRenderer::MappedWindow(const SubmapGrid& grid, const Pose2& T_map_submap) {
  const LogOddsGrid& cells = grid.log_odds();
  const double r = cells.resolution();
  const CellIndex min = cells.window_min();
  Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::max());
  Eigen::Vector2d high = -low;
  for (const int column : {min.column, min.column + cells.width()}) {
    for (const int row : {min.row, min.row + cells.height()}) {
      const Eigen::Vector2d corner = T_map_submap * Eigen::Vector2d(column * r, row * r);
      low = low.cwiseMin(corner);
      high = high.cwiseMax(corner);
    }
  }
  const CellIndex first = cells.CellOf(low);
  const CellIndex last = cells.CellOf(high);
  return {first, last.column - first.column + 1, last.row - first.row + 1};
}

bool MapRenderer::Cover(Raster& raster, const Window& needed) {
  const Window& old = raster.window;
  const auto low = [&](int a, int b) { return FloorToBlock(old.empty() ? b : std::min(a, b)); };
  const auto high = [&](int a, int b) { return FloorToBlock((old.empty() ? b : std::max(a, b)) + kBlock - 1); };
  const int left = low(old.min.column, needed.min.column);
  const int bottom = low(old.min.row, needed.min.row);
  const int right = high(old.min.column + old.width, needed.min.column + needed.width);
  const int top = high(old.min.row + old.height, needed.min.row + needed.height);
  if (static_cast<double>(right - left) * (top - bottom) > kMaxCells) return false;
  const Window grown{{left, bottom}, right - left, top - bottom};
  if (grown.width == old.width && grown.height == old.height) return true;
  std::vector<Cell> cells(grown.cell_count());
  for (int row = old.min.row; row < old.min.row + old.height; ++row) {
    std::copy_n(raster.cells.begin() + static_cast<std::ptrdiff_t>(old.index(old.min.column, row)), old.width,
                cells.begin() + static_cast<std::ptrdiff_t>(grown.index(old.min.column, row)));
  }
  raster.window = grown;
  raster.cells = std::move(cells);
  return true;
}

void MapRenderer::Add(Raster& raster, const SubmapGrid& grid, const Pose2& T_map_submap, int sign) const {
  const LogOddsGrid& cells = grid.log_odds();
  if (cells.cells().empty()) return;
  const Window mapped = MappedWindow(grid, T_map_submap);
  if (!Cover(raster, mapped)) return;
  const Pose2 T_submap_map = Inverse(T_map_submap);
  const double c = std::cos(T_submap_map.yaw);
  const double s = std::sin(T_submap_map.yaw);
  for (int row = mapped.min.row; row < mapped.min.row + mapped.height; ++row) {
    Cell* target = &raster.cells[raster.window.index(mapped.min.column, row)];
    const double y = (row + 0.5) * resolution_;
    for (int column = mapped.min.column; column < mapped.min.column + mapped.width; ++column, ++target) {
      const double x = (column + 0.5) * resolution_;
      const auto value = cells.ValueAt(cells.CellOf({T_submap_map.x + c * x - s * y, T_submap_map.y + s * x + c * y}));
      if (value == LogOddsGrid::kUnknown) continue;
      target->log_odds += sign * value;
      target->known += sign;
    }
  }
}

MapRenderer::Window MapRenderer::KnownWindow(const Raster& raster) {
  const Window& w = raster.window;
  int left = std::numeric_limits<int>::max();
  int right = std::numeric_limits<int>::min();
  int bottom = left;
  int top = right;
  for (int row = w.min.row; row < w.min.row + w.height; ++row) {
    for (int column = w.min.column; column < w.min.column + w.width; ++column) {
      if (raster.cells[w.index(column, row)].known == 0) continue;
      left = std::min(left, column);
      right = std::max(right, column);
      bottom = std::min(bottom, row);
      top = std::max(top, row);
    }
  }
  if (right < left) return {};
  return {{left, bottom}, right - left + 1, top - bottom + 1};
}

}  // namespace enfilade
