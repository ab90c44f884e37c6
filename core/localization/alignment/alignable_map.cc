// SPDX-License-Identifier: Apache-2.0
#include "core/localization/alignment/alignable_map.h"

#include <algorithm>
#include <cmath>

namespace enfilade::localization {
namespace {

// Cells around a wall in which free ground shows its open side.
constexpr int kBeside = 2;

}  // namespace

AlignableMap::AlignableMap(const grid::OccupancyGrid& grid, const LocalizationOptions& options)
    : resolution_(grid.geometry.resolution), searchable_(grid, options) {
  const auto middle = [&](int column, int row) -> Eigen::Vector2d {
    return grid.geometry.T_map_grid * Eigen::Vector2d((column + 0.5) * resolution_, (row + 0.5) * resolution_);
  };
  const auto is_free = [&](int column, int row) {
    return grid.geometry.contains(column, row) && searchable_.At(middle(column, row)) == SearchableMap::Cell::kFree;
  };
  const int step = std::max(1, static_cast<int>(std::lround(kGroundSpacing / resolution_)));
  for (int row = 0; row < grid.geometry.height; ++row) {
    for (int column = 0; column < grid.geometry.width; ++column) {
      const Eigen::Vector2d point = middle(column, row);
      const SearchableMap::Cell cell = searchable_.At(point);
      if (cell == SearchableMap::Cell::kFree && row % step == 0 && column % step == 0) ground_.push_back(point);
      if (cell != SearchableMap::Cell::kOccupied) continue;
      if (!is_free(column + 1, row) && !is_free(column - 1, row) && !is_free(column, row + 1) &&
          !is_free(column, row - 1)) {
        continue;
      }
      Eigen::Vector2d open = Eigen::Vector2d::Zero();
      for (int dy = -kBeside; dy <= kBeside; ++dy) {
        for (int dx = -kBeside; dx <= kBeside; ++dx) {
          if (is_free(column + dx, row + dy)) open += Eigen::Vector2d(dx, dy);
        }
      }
      const double length = open.norm();
      surfaces_.push_back({point, length > 0.5 ? Eigen::Vector2d(open / length) : Eigen::Vector2d::Zero()});
    }
  }
}

}  // namespace enfilade::localization
