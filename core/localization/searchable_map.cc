// SPDX-License-Identifier: Apache-2.0
#include "core/localization/searchable_map.h"

#include <cmath>

namespace enfilade::localization {
namespace {

constexpr double kReach = 0.5;        // m, of the field for refining
constexpr double kReachSigmas = 4.0;  // of the field for searching: beyond, the table holds 0
constexpr int kTableLevels = 7;
constexpr int kOccupiedFrom = 129;  // more likely occupied than not
constexpr int kBesideGround = 2;    // cells of the search around ground that has been seen

slam::CellWindow WindowOf(const grid::GridGeometry& geometry) {
  const double r = geometry.resolution;
  return {{static_cast<int>(std::lround(geometry.T_map_grid.x / r)),
           static_cast<int>(std::lround(geometry.T_map_grid.y / r))},
          geometry.width,
          geometry.height};
}

std::vector<SearchableMap::Cell> Classify(const grid::OccupancyGrid& grid) {
  std::vector<SearchableMap::Cell> cells(grid.cells.size(), SearchableMap::Cell::kUnknown);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (grid.cells[i] == grid::kUnknownCell) continue;
    cells[i] = grid.cells[i] >= kOccupiedFrom ? SearchableMap::Cell::kOccupied : SearchableMap::Cell::kFree;
  }
  return cells;
}

}  // namespace

SearchableMap::SearchableMap(const grid::OccupancyGrid& grid, const LocalizationOptions& options)
    : resolution_(grid.geometry.resolution),
      window_(WindowOf(grid.geometry)),
      cells_(Classify(grid)),
      walls_(grid.geometry.resolution, kReach),
      table_(options.search_sigma, kTableLevels) {
  std::vector<Eigen::Vector2d> points;
  for (int row = window_.min.row; row < window_.top(); ++row) {
    for (int column = window_.min.column; column < window_.right(); ++column) {
      if (cells_[window_.index(column, row)] != Cell::kOccupied) continue;
      points.emplace_back((column + 0.5) * resolution_, (row + 0.5) * resolution_);
    }
  }
  if (points.empty()) return;
  walls_.Add(points);
  slam::LikelihoodField coarse(options.search_cell, kReachSigmas * options.search_sigma);
  coarse.Add(points);
  bounds_ = BoundTable(coarse, options.search_sigma, kTableLevels);
  table_.Update(coarse, coarse.window());
  SumGround(options.search_cell);
}

void SearchableMap::SumGround(double cell) {
  const auto coarse = [&](int fine) { return static_cast<int>(std::floor((fine + 0.5) * resolution_ / cell)); };
  ground_ = slam::Dilated(slam::WindowBetween(coarse(window_.min.column), coarse(window_.min.row),
                                              coarse(window_.right()) + 1, coarse(window_.top()) + 1),
                          kBesideGround);
  std::vector<std::uint8_t> is_free(ground_.cell_count(), 0);
  std::vector<std::uint8_t> stands(ground_.cell_count(), 0);
  for (int row = window_.min.row; row < window_.top(); ++row) {
    for (int column = window_.min.column; column < window_.right(); ++column) {
      if (cells_[window_.index(column, row)] != Cell::kFree) continue;
      empty_ = false;
      std::uint8_t& seen = is_free[ground_.index(coarse(column), coarse(row))];
      if (seen != 0) continue;
      seen = 1;
      const slam::CellWindow near = slam::Dilated({{coarse(column), coarse(row)}, 1, 1}, kBesideGround);
      for (int r = near.min.row; r < near.top(); ++r) {
        for (int c = near.min.column; c < near.right(); ++c) stands[ground_.index(c, r)] = 1;
      }
    }
  }
  const auto width = static_cast<std::size_t>(ground_.width) + 1;
  ground_sums_.assign(width * (static_cast<std::size_t>(ground_.height) + 1), 0);
  for (std::size_t row = 0; row < static_cast<std::size_t>(ground_.height); ++row) {
    for (std::size_t column = 0; column + 1 < width; ++column) {
      ground_sums_[(row + 1) * width + column + 1] =
          stands[row * (width - 1) + column] + ground_sums_[row * width + column + 1] +
          ground_sums_[(row + 1) * width + column] - ground_sums_[row * width + column];
    }
  }
}

SearchableMap::Cell SearchableMap::At(const Eigen::Vector2d& point) const {
  const double column = std::floor(point.x() / resolution_);
  const double row = std::floor(point.y() / resolution_);
  if (!(std::abs(column) < 1e9 && std::abs(row) < 1e9)) return Cell::kUnknown;
  const grid::CellIndex cell{static_cast<int>(column), static_cast<int>(row)};
  return window_.contains(cell.column, cell.row) ? cells_[window_.index(cell.column, cell.row)] : Cell::kUnknown;
}

bool SearchableMap::HasGround(const slam::CellWindow& cells) const {
  const slam::CellWindow w = slam::Intersection(cells, ground_);
  if (w.empty()) return false;
  const auto width = static_cast<std::size_t>(ground_.width) + 1;
  const auto left = static_cast<std::size_t>(w.min.column - ground_.min.column);
  const auto bottom = static_cast<std::size_t>(w.min.row - ground_.min.row);
  const std::size_t right = left + static_cast<std::size_t>(w.width);
  const std::size_t top = bottom + static_cast<std::size_t>(w.height);
  return ground_sums_[top * width + right] - ground_sums_[bottom * width + right] - ground_sums_[top * width + left] +
             ground_sums_[bottom * width + left] >
         0;
}

std::size_t SearchableMap::bytes() const {
  return cells_.capacity() + walls_.bytes() + bounds_.bytes() + table_.bytes() +
         ground_sums_.capacity() * sizeof(std::int32_t);
}

}  // namespace enfilade::localization
