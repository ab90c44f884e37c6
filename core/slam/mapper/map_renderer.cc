// SPDX-License-Identifier: Apache-2.0
#include "core/slam/mapper/map_renderer.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <set>

namespace enfilade::slam {
namespace {

// The largest grid: 800 m x 800 m at 5 cm. Submaps that would make it larger are left out.
constexpr double kMaxCells = 1 << 28;
constexpr int kTileBits = 7;
constexpr int kTile = 1 << kTileBits;        // cells: 6.4 m at 5 cm
constexpr double kPositionStep = 1.0 / 8.0;  // of a cell
constexpr double kYawStep = 5e-4;            // rad

double LogOdds(double p) { return std::log(p / (1.0 - p)); }

double CellCount(const CellWindow& window) { return static_cast<double>(window.width) * window.height; }

// As std::floor, for values that an int can hold, without a call.
int Floor(double value) {
  const int truncated = static_cast<int>(value);
  return truncated - (value < truncated ? 1 : 0);
}

// Most of the time to render goes into stepping from cell to cell, which is faster with integers. Over the cells of a
// tile, steps rounded to this fraction of a cell add up to less than a ten millionth of one.
constexpr int kFixedBits = 32;
std::int64_t ToFixed(double value) { return std::llround(value * static_cast<double>(std::int64_t{1} << kFixedBits)); }

// Positions x in [low, high] along a line.
struct Interval {
  double low;
  double high;

  // Keeps those at which offset + slope * x lies within [min, max].
  void Clip(double offset, double slope, double min, double max) {
    constexpr double kParallel = 1e-9;
    if (std::abs(slope) < kParallel) {
      if (offset < min || offset > max) high = low - 1.0;
      return;
    }
    const double a = (min - offset) / slope;
    const double b = (max - offset) / slope;
    low = std::max(low, std::min(a, b));
    high = std::min(high, std::max(a, b));
  }
};

}  // namespace

MapRenderer::MapRenderer(double resolution, const grid::LogOddsOptions& options)
    : resolution_(resolution),
      lowest_(Floor(LogOdds(options.p_min) * grid::LogOddsGrid::kUnitsPerLogOdds)),
      highest_(Floor(LogOdds(options.p_max) * grid::LogOddsGrid::kUnitsPerLogOdds) + 1) {
  for (std::int32_t sum = lowest_; sum <= highest_; ++sum) {
    const double log_odds =
        std::clamp(sum / grid::LogOddsGrid::kUnitsPerLogOdds, LogOdds(options.p_min), LogOdds(options.p_max));
    cell_of_.push_back(grid::CellFromProbability(1.0 / (1.0 + std::exp(-log_odds))));
  }
}

bool MapRenderer::Place(std::int64_t submap, const Pose2& T_map_submap,
                        const std::function<const SubmapGrid&()>& grid) {
  const Pose2 rounded = Rounded(T_map_submap);
  const auto placed = placed_.find(submap);
  if (placed != placed_.end() && placed->second == rounded) return false;
  const SubmapGrid& drawn = grid();
  const CellWindow grown = Union(window_, MappedWindow(drawn, rounded));
  if (CellCount(grown) > kMaxCells) return false;
  window_ = grown;
  if (placed != placed_.end()) Add(tiles_, drawn, placed->second, -1);
  Add(tiles_, drawn, rounded, +1);
  placed_[submap] = rounded;
  return true;
}

void MapRenderer::Expect(const std::map<std::int64_t, Pose2>& T_map_submaps) {
  std::size_t staying = 0;
  for (const auto& [submap, pose] : placed_) {
    const auto expected = T_map_submaps.find(submap);
    if (expected == T_map_submaps.end() || Rounded(expected->second) == pose) ++staying;
  }
  if (2 * staying >= placed_.size()) return;
  placed_.clear();
  tiles_.clear();
}

grid::OccupancyGrid MapRenderer::Render(const SubmapGrid* active, const Pose2& T_map_active) const {
  Tiles drawn;
  if (active && CellCount(Union(window_, MappedWindow(*active, Rounded(T_map_active)))) <= kMaxCells) {
    Add(drawn, *active, Rounded(T_map_active), +1);
  }
  const CellWindow known = Union(KnownWindow(tiles_), KnownWindow(drawn));
  grid::OccupancyGrid grid;
  grid.geometry.resolution = resolution_;
  if (known.empty()) return grid;
  grid.geometry.width = known.width;
  grid.geometry.height = known.height;
  grid.geometry.T_map_grid = {known.min.column * resolution_, known.min.row * resolution_, 0.0};
  grid.cells.assign(grid.geometry.cell_count(), grid::kUnknownCell);
  std::set<TileIndex> indices;
  for (const Tiles* tiles : {&tiles_, static_cast<const Tiles*>(&drawn)}) {
    for (const auto& [index, cells] : *tiles) indices.insert(index);
  }
  for (const TileIndex& index : indices) DrawTile(index, tiles_, drawn, grid);
  return grid;
}

std::size_t MapRenderer::bytes() const { return tiles_.size() * kTile * kTile * sizeof(Cell); }

Pose2 MapRenderer::Rounded(const Pose2& pose) const {
  const double step = resolution_ * kPositionStep;
  return {std::round(pose.x / step) * step, std::round(pose.y / step) * step,
          std::round(pose.yaw / kYawStep) * kYawStep};
}

CellWindow MapRenderer::WindowOf(const TileIndex& tile) {
  return {{tile.second * kTile, tile.first * kTile}, kTile, kTile};
}

// The cells of the map that the grid at `T_map_submap` can touch.
CellWindow MapRenderer::MappedWindow(const SubmapGrid& grid, const Pose2& T_map_submap) {
  const grid::LogOddsGrid& cells = grid.log_odds();
  if (cells.cells().empty()) return {};
  const double r = cells.resolution();
  const grid::CellIndex min = cells.window_min();
  Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::max());
  Eigen::Vector2d high = -low;
  for (const int column : {min.column, min.column + cells.width()}) {
    for (const int row : {min.row, min.row + cells.height()}) {
      const Eigen::Vector2d corner = T_map_submap * Eigen::Vector2d(column * r, row * r);
      low = low.cwiseMin(corner);
      high = high.cwiseMax(corner);
    }
  }
  const grid::CellIndex first = cells.CellOf(low);
  const grid::CellIndex last = cells.CellOf(high);
  return WindowBetween(first.column, first.row, last.column + 1, last.row + 1);
}

CellWindow MapRenderer::KnownWindow(const Tiles& tiles) {
  const auto is_known = [](const Cell& cell) { return cell.known != 0; };
  CellWindow known;
  for (const auto& [index, cells] : tiles) {
    const CellWindow w = WindowOf(index);
    // A tile inside the known window adds nothing.
    if (Union(known, w) == known) continue;
    for (int row = w.min.row; row < w.top(); ++row) {
      const auto begin = cells.begin() + static_cast<std::ptrdiff_t>(w.index(w.min.column, row));
      const auto end = begin + kTile;
      const auto first = std::find_if(begin, end, is_known);
      if (first == end) continue;
      const auto past_last = std::find_if(std::make_reverse_iterator(end), std::make_reverse_iterator(first), is_known);
      const auto column = w.min.column + static_cast<int>(first - begin);
      known = Union(known, {{column, row}, static_cast<int>(past_last.base() - first), 1});
    }
  }
  return known;
}

void MapRenderer::Add(Tiles& tiles, const SubmapGrid& grid, const Pose2& T_map_submap, int sign) const {
  const CellWindow mapped = MappedWindow(grid, T_map_submap);
  if (mapped.empty()) return;
  const KnownBlocks known(grid.log_odds());
  const PlacedGrid placed{grid, known, Inverse(T_map_submap), mapped};
  for (int row = mapped.min.row >> kTileBits; row <= (mapped.top() - 1) >> kTileBits; ++row) {
    for (int column = mapped.min.column >> kTileBits; column <= (mapped.right() - 1) >> kTileBits; ++column) {
      AddToTile(tiles, {row, column}, placed, sign);
    }
  }
}

void MapRenderer::AddToTile(Tiles& tiles, const TileIndex& index, const PlacedGrid& placed, int sign) const {
  const grid::LogOddsGrid& cells = placed.grid.log_odds();
  const Pose2& T_submap_map = placed.T_submap_map;
  const CellWindow tile = WindowOf(index);
  const CellWindow w = Intersection(tile, placed.window);
  const double r = cells.resolution();
  const double c = std::cos(T_submap_map.yaw);
  const double s = std::sin(T_submap_map.yaw);
  const grid::CellIndex min = cells.window_min();
  const std::int16_t* values = cells.cells().data();
  const auto width = static_cast<std::uint64_t>(cells.width());
  const auto height = static_cast<std::uint64_t>(cells.height());
  const std::int64_t column_step = ToFixed(c * resolution_ / r);
  const std::int64_t row_step = ToFixed(s * resolution_ / r);
  // That many columns of the map are no longer than a block.
  const int stride = std::max(1, static_cast<int>(KnownBlocks::kSide * r / resolution_));
  std::vector<Cell>* sums = nullptr;
  const auto add = [&](int row, int column, std::int64_t from_column, std::int64_t from_row) {
    // Negative indices become large ones.
    if (static_cast<std::uint64_t>(from_column) >= width || static_cast<std::uint64_t>(from_row) >= height) return;
    const std::int16_t value =
        values[static_cast<std::size_t>(from_row) * width + static_cast<std::size_t>(from_column)];
    if (value == grid::LogOddsGrid::kUnknown) return;
    if (sums == nullptr) {
      sums = &tiles[index];
      sums->resize(tile.cell_count());
    }
    Cell& sum = (*sums)[tile.index(column, row)];
    sum.log_odds += sign * value;
    sum.known += sign;
  };
  for (int row = w.min.row; row < w.top(); ++row) {
    const double y = (row + 0.5) * resolution_;
    // The columns whose centres lie in the submap's window, and one more on each side.
    Interval in{w.min.column * resolution_, w.right() * resolution_};
    in.Clip(T_submap_map.x - s * y, c, (min.column - 1) * r, (min.column + cells.width() + 1) * r);
    in.Clip(T_submap_map.y + c * y, s, (min.row - 1) * r, (min.row + cells.height() + 1) * r);
    if (in.high < in.low) continue;
    const int first = std::max(w.min.column, Floor(in.low / resolution_) - 1);
    const int end = std::min(w.right(), Floor(in.high / resolution_) + 2);
    const double x = (first + 0.5) * resolution_;
    std::int64_t column_at = ToFixed((T_submap_map.x + c * x - s * y) / r - min.column);
    std::int64_t row_at = ToFixed((T_submap_map.y + s * x + c * y) / r - min.row);
    for (int column = first; column < end;) {
      const int next = std::min(column + stride, end);
      if (!placed.known.IsNear(column_at >> kFixedBits, row_at >> kFixedBits)) {
        column_at += (next - column) * column_step;
        row_at += (next - column) * row_step;
        column = next;
        continue;
      }
      for (; column < next; ++column, column_at += column_step, row_at += row_step) {
        add(row, column, column_at >> kFixedBits, row_at >> kFixedBits);
      }
    }
  }
  const auto unknown = [](const Cell& cell) { return cell.known == 0; };
  if (sign < 0 && sums != nullptr && std::all_of(sums->begin(), sums->end(), unknown)) tiles.erase(index);
}

const MapRenderer::Cell* MapRenderer::FindCells(const Tiles& tiles, const TileIndex& index) {
  const auto found = tiles.find(index);
  return found == tiles.end() ? nullptr : found->second.data();
}

void MapRenderer::DrawTile(const TileIndex& index, const Tiles& placed, const Tiles& active,
                           grid::OccupancyGrid& grid) const {
  const grid::CellIndex first{static_cast<int>(std::lround(grid.geometry.T_map_grid.x / resolution_)),
                              static_cast<int>(std::lround(grid.geometry.T_map_grid.y / resolution_))};
  const CellWindow tile = WindowOf(index);
  const CellWindow w = Intersection(tile, {first, grid.geometry.width, grid.geometry.height});
  const auto draw = [&](auto&& sum_at) {
    for (int row = w.min.row; row < w.top(); ++row) {
      std::uint8_t* const to = &grid.cells[grid.geometry.index(w.min.column - first.column, row - first.row)];
      const std::size_t from = tile.index(w.min.column, row);
      for (int i = 0; i < w.width; ++i) {
        const Cell cell = sum_at(from + static_cast<std::size_t>(i));
        if (cell.known == 0) continue;
        to[i] = cell_of_[static_cast<std::size_t>(std::clamp(cell.log_odds, lowest_, highest_) - lowest_)];
      }
    }
  };
  const Cell* const a = FindCells(placed, index);
  const Cell* const b = FindCells(active, index);
  if (a != nullptr && b != nullptr) {
    draw([=](std::size_t i) { return Cell{a[i].log_odds + b[i].log_odds, a[i].known + b[i].known}; });
  } else {
    draw([cells = a != nullptr ? a : b](std::size_t i) { return cells[i]; });
  }
}

}  // namespace enfilade::slam
