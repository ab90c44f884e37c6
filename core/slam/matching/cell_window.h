// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>

#include "core/grid/bresenham.h"

namespace enfilade::slam {

// A rectangle of cells of a lattice, stored row by row.
struct CellWindow {
  grid::CellIndex min;
  int width = 0;
  int height = 0;

  bool empty() const { return width <= 0 || height <= 0; }
  int right() const { return min.column + width; }  // one past the last column
  int top() const { return min.row + height; }      // one past the last row
  std::size_t cell_count() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
  bool contains(int column, int row) const {
    return column >= min.column && row >= min.row && column < right() && row < top();
  }
  std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row - min.row) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(column - min.column);
  }

  friend bool operator==(const CellWindow&, const CellWindow&) = default;
};

inline CellWindow WindowBetween(int left, int bottom, int right, int top) {
  return {{left, bottom}, right - left, top - bottom};
}

inline CellWindow Dilated(const CellWindow& w, int margin) {
  return {{w.min.column - margin, w.min.row - margin}, w.width + 2 * margin, w.height + 2 * margin};
}

inline CellWindow Union(const CellWindow& a, const CellWindow& b) {
  if (a.empty()) return b;
  if (b.empty()) return a;
  return WindowBetween(std::min(a.min.column, b.min.column), std::min(a.min.row, b.min.row),
                       std::max(a.right(), b.right()), std::max(a.top(), b.top()));
}

inline CellWindow Intersection(const CellWindow& a, const CellWindow& b) {
  const CellWindow both = WindowBetween(std::max(a.min.column, b.min.column), std::max(a.min.row, b.min.row),
                                        std::min(a.right(), b.right()), std::min(a.top(), b.top()));
  return both.empty() ? CellWindow{} : both;
}

}  // namespace enfilade::slam
