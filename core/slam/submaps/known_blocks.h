// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/grid/log_odds_grid.h"

namespace enfilade::slam {

// Where a grid's cells are known, by blocks of cells, so that drawing can skip what is far from any: most of a submap's
// window is unknown.
class KnownBlocks {
 public:
  static constexpr int kSide = 16;  // cells

  explicit KnownBlocks(const grid::LogOddsGrid& grid);

  // Whether a cell at most kSide columns and kSide rows from this one may be known. `column` and `row` count from the
  // grid's window_min(); they may lie outside of its window.
  bool IsNear(std::int64_t column, std::int64_t row) const;

 private:
  void MarkAround(int column, int row);

  int columns_;
  int rows_;
  std::vector<std::uint8_t> near_;  // row by row
};

}  // namespace enfilade::slam
