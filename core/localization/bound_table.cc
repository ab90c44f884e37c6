// SPDX-License-Identifier: Apache-2.0
#include "core/localization/bound_table.h"

#include <algorithm>
#include <cmath>

namespace enfilade::localization {

BoundTable::BoundTable(const slam::LikelihoodField& field, double sigma, int levels)
    : resolution_(field.resolution()), levels_(static_cast<std::size_t>(std::max(levels, 1))) {
  Level& lowest = levels_.front();
  lowest.window = field.window();
  for (const float squared_distance : field.squared_distances()) {
    lowest.cells.push_back(
        static_cast<std::uint8_t>(std::lround(255.0 * std::exp(-squared_distance / (2.0 * sigma * sigma)))));
  }
  // A block is two blocks of half its width on each axis.
  for (std::size_t k = 1; k < levels_.size(); ++k) {
    const int half = 1 << (k - 1);
    const View finer = ViewOf(static_cast<int>(k) - 1);
    Level& level = levels_[k];
    const slam::CellWindow& below = levels_[k - 1].window;
    level.window = slam::WindowBetween(below.min.column - half, below.min.row - half, below.right(), below.top());
    level.cells.reserve(level.window.cell_count());
    for (int row = level.window.min.row; row < level.window.top(); ++row) {
      for (int column = level.window.min.column; column < level.window.right(); ++column) {
        level.cells.push_back(static_cast<std::uint8_t>(
            std::max(std::max(finer.At(column, row), finer.At(column + half, row)),
                     std::max(finer.At(column, row + half), finer.At(column + half, row + half)))));
      }
    }
  }
}

std::size_t BoundTable::bytes() const {
  std::size_t bytes = 0;
  for (const Level& level : levels_) bytes += level.cells.capacity();
  return bytes;
}

BoundTable::View BoundTable::ViewOf(int level) const {
  const Level& l = levels_[static_cast<std::size_t>(level)];
  return {l.cells.data(), l.window.min.column, l.window.min.row, static_cast<unsigned>(l.window.width),
          static_cast<unsigned>(l.window.height)};
}

}  // namespace enfilade::localization
