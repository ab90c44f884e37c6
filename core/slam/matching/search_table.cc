// SPDX-License-Identifier: Apache-2.0
#include "core/slam/matching/search_table.h"

#include <algorithm>
#include <cmath>

namespace enfilade::slam {
namespace {

// The cells of `level` that cover `window` of level 0.
CellWindow AtLevel(const CellWindow& window, int level) {
  return WindowBetween(window.min.column >> level, window.min.row >> level, ((window.right() - 1) >> level) + 1,
                       ((window.top() - 1) >> level) + 1);
}

}  // namespace

SearchTable::SearchTable(double sigma, int levels)
    : sigma_(sigma), blocks_(static_cast<std::size_t>(levels)), levels_(static_cast<std::size_t>(levels)) {}

std::size_t SearchTable::bytes() const {
  std::size_t bytes = 0;
  for (const std::vector<Level>* levels : {&blocks_, &levels_}) {
    for (const Level& level : *levels) bytes += level.cells.capacity();
  }
  return bytes;
}

void SearchTable::Update(const LikelihoodField& field, const CellWindow& changed) {
  if (changed.empty()) return;
  resolution_ = field.resolution();
  Cover(field.window());
  UpdateLikelihoods(field, changed);
  for (int level = 1; level < levels(); ++level) UpdateBounds(level, changed);
}

// Higher levels have one more cell on each side: their entries also cover the next block to the right and above.
void SearchTable::Cover(const CellWindow& field_window) {
  for (int k = 0; k < levels(); ++k) {
    CellWindow window = AtLevel(field_window, k);
    if (k > 0) window = Dilated(window, 1);
    for (std::vector<Level>* tables : {&blocks_, &levels_}) {
      Level& level = (*tables)[static_cast<std::size_t>(k)];
      if (level.window == window) continue;
      std::vector<std::uint8_t> cells(window.cell_count(), 0);
      for (int row = level.window.min.row; row < level.window.top(); ++row) {
        std::copy_n(level.cells.begin() + static_cast<std::ptrdiff_t>(level.window.index(level.window.min.column, row)),
                    level.window.width,
                    cells.begin() + static_cast<std::ptrdiff_t>(window.index(level.window.min.column, row)));
      }
      level.window = window;
      level.cells = std::move(cells);
    }
  }
}

void SearchTable::UpdateLikelihoods(const LikelihoodField& field, const CellWindow& changed) {
  constexpr int kSteps = 1024;
  const double max_d2 = 16.0 * sigma_ * sigma_;  // beyond 4 sigma the likelihood is 0
  std::vector<std::uint8_t> likelihood(kSteps + 1, 0);
  for (int i = 0; i < kSteps; ++i) {
    likelihood[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(
        std::lround(255.0 * std::exp(-(i + 0.5) / kSteps * max_d2 / (2.0 * sigma_ * sigma_))));
  }
  const auto scale = static_cast<float>(kSteps / max_d2);
  Level& target = levels_[0];
  for (int row = changed.min.row; row < changed.top(); ++row) {
    const float* source = &field.squared_distances()[field.window().index(changed.min.column, row)];
    std::uint8_t* to = &target.cells[target.window.index(changed.min.column, row)];
    for (int i = 0; i < changed.width; ++i) {
      to[i] = likelihood[static_cast<std::size_t>(std::min(source[i] * scale, static_cast<float>(kSteps)))];
    }
  }
}

void SearchTable::UpdateBounds(int level, const CellWindow& changed) {
  const auto k = static_cast<std::size_t>(level);
  const CellWindow touched = AtLevel(changed, level);
  MaxOfSquares(level == 1 ? levels_[0] : blocks_[k - 1], 2, touched, blocks_[k]);
  MaxOfSquares(blocks_[k], 1,
               WindowBetween(touched.min.column - 1, touched.min.row - 1, touched.right(), touched.top()), levels_[k]);
}

// Cell (c, r) of `target` becomes the largest of the 2 x 2 cells of `source` from (step c, step r) on.
void SearchTable::MaxOfSquares(const Level& source, int step, const CellWindow& cells, Level& target) {
  const auto at = [&](int column, int row) -> std::uint8_t {
    return source.window.contains(column, row) ? source.cells[source.window.index(column, row)] : std::uint8_t{0};
  };
  for (int row = cells.min.row; row < cells.top(); ++row) {
    std::uint8_t* const to = &target.cells[target.window.index(cells.min.column, row)];
    const int left = step * cells.min.column;
    const int right = step * (cells.right() - 1) + 1;
    if (source.window.contains(left, step * row) && source.window.contains(right, step * row + 1)) {
      const std::uint8_t* const low = &source.cells[source.window.index(left, step * row)];
      const std::uint8_t* const high = low + source.window.width;
      for (int i = 0; i < cells.width; ++i) {
        const int c = step * i;
        to[i] = std::max(std::max(low[c], low[c + 1]), std::max(high[c], high[c + 1]));
      }
      continue;
    }
    for (int i = 0; i < cells.width; ++i) {  // along the border
      const int c = left + step * i;
      const int r = step * row;
      to[i] = std::max(std::max(at(c, r), at(c + 1, r)), std::max(at(c, r + 1), at(c + 1, r + 1)));
    }
  }
}

}  // namespace enfilade::slam
