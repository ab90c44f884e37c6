// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>

namespace enfilade::grid {

// A cell on an unbounded lattice.
struct CellIndex {
  int column = 0;
  int row = 0;

  friend bool operator==(const CellIndex&, const CellIndex&) = default;
};

// Bresenham's line (J. E. Bresenham, "Algorithm for computer control of a digital plotter", IBM Systems Journal 1965)
// as a recurrence: `steps` steps along the longer axis. Each step adds `up` to `error`; if that makes it >= 0, the line
// also steps along the shorter axis and `error -= down`. Ties go to the cell with the greater coordinate on the shorter
// axis in either direction, so a line and its reverse have the same cells.
struct BresenhamLine {
  BresenhamLine(CellIndex from, CellIndex to) {
    const std::int64_t dx = std::int64_t{to.column} - from.column;
    const std::int64_t dy = std::int64_t{to.row} - from.row;
    column_is_longer = std::abs(dx) >= std::abs(dy);
    steps = column_is_longer ? std::abs(dx) : std::abs(dy);
    const std::int64_t shorter = column_is_longer ? dy : dx;
    column_sign = dx < 0 ? -1 : 1;
    row_sign = dy < 0 ? -1 : 1;
    up = 2 * std::abs(shorter);
    down = 2 * steps;
    error = -steps - (shorter < 0 ? 1 : 0);
  }

  bool column_is_longer;
  int column_sign;
  int row_sign;
  std::int64_t steps;
  std::int64_t up;
  std::int64_t down;
  std::int64_t error;
};

// Calls visit(CellIndex) for each cell of the line, both ends included, in order, each once; consecutive cells touch
// at a side or a corner (8-connected).
template <typename Visit>
void VisitLine(CellIndex from, CellIndex to, Visit&& visit) {
  const BresenhamLine line(from, to);
  const int longer_column = line.column_is_longer ? line.column_sign : 0;
  const int longer_row = line.column_is_longer ? 0 : line.row_sign;
  const int shorter_column = line.column_is_longer ? 0 : line.column_sign;
  const int shorter_row = line.column_is_longer ? line.row_sign : 0;
  std::int64_t error = line.error;
  CellIndex cell = from;
  visit(cell);
  for (std::int64_t i = 0; i < line.steps; ++i) {
    cell.column += longer_column;
    cell.row += longer_row;
    error += line.up;
    if (error >= 0) {
      cell.column += shorter_column;
      cell.row += shorter_row;
      error -= line.down;
    }
    visit(cell);
  }
}

// The same cells as offsets into a row-major array: visit(std::ptrdiff_t), starting at `offset_of_from`; a row has
// `stride` elements. Both ends must lie inside the array; then all cells do.
//
// The position along the shorter axis is in fixed point: one addition per step instead of the recurrence's chain of
// four, with the same result. With F fractional bits the rounding of the slope adds up to less than steps / 2^F of a
// cell, and exact positions are multiples of 1 / (2 steps): below 2^19 steps the error cannot change a cell.
template <typename Visit>
void VisitLineOffsets(CellIndex from, CellIndex to, std::ptrdiff_t offset_of_from, std::ptrdiff_t stride,
                      Visit&& visit) {
  constexpr int kFractionBits = 40;
  constexpr std::int64_t kOne = std::int64_t{1} << kFractionBits;
  constexpr std::int64_t kMaxSteps = std::int64_t{1} << 19;
  const BresenhamLine line(from, to);
  if (line.steps == 0) return visit(offset_of_from);
  if (line.steps >= kMaxSteps) {
    return VisitLine(from, to, [&](CellIndex cell) {
      visit(offset_of_from + (cell.row - from.row) * stride + (cell.column - from.column));
    });
  }
  const std::ptrdiff_t by_column = line.column_sign;
  const std::ptrdiff_t by_row = line.row_sign * stride;
  const std::ptrdiff_t longer = line.column_is_longer ? by_column : by_row;
  const std::ptrdiff_t shorter = line.column_is_longer ? by_row : by_column;
  // If ties stay on the lower cell, round down and start just below one half; otherwise round up.
  const bool tie_stays = line.error < -line.steps;
  const std::int64_t slope = ((line.up / 2) * kOne + (tie_stays ? 0 : line.steps - 1)) / line.steps;
  std::int64_t position = kOne / 2 - (tie_stays ? 1 : 0);
  std::ptrdiff_t offset = offset_of_from;
  for (std::int64_t i = 0; i <= line.steps; ++i) {
    visit(offset + shorter * (position >> kFractionBits));
    offset += longer;
    position += slope;
  }
}

}  // namespace enfilade::grid
