// SPDX-License-Identifier: Apache-2.0
#include "core/slam/submaps/known_blocks.h"

#include <algorithm>

namespace enfilade::slam {
namespace {

bool IsAnyKnown(const std::int16_t* values, std::size_t count) {
  std::int16_t most = grid::LogOddsGrid::kUnknown;  // all others are larger
  for (std::size_t i = 0; i < count; ++i) most = std::max(most, values[i]);
  return most != grid::LogOddsGrid::kUnknown;
}

}  // namespace

KnownBlocks::KnownBlocks(const grid::LogOddsGrid& grid)
    : columns_((grid.width() + kSide - 1) / kSide),
      rows_((grid.height() + kSide - 1) / kSide),
      near_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), 0) {
  const auto width = static_cast<std::size_t>(grid.width());
  for (int row = 0; row < grid.height(); ++row) {
    const std::int16_t* values = grid.cells().data() + static_cast<std::size_t>(row) * width;
    for (int block = 0; block < columns_; ++block) {
      const std::size_t begin = static_cast<std::size_t>(block) * kSide;
      if (IsAnyKnown(values + begin, std::min<std::size_t>(kSide, width - begin))) MarkAround(block, row / kSide);
    }
  }
}

bool KnownBlocks::IsNear(std::int64_t column, std::int64_t row) const {
  if (near_.empty()) return false;
  // The block with the nearest cell of the window.
  const std::int64_t x = std::clamp<std::int64_t>(column / kSide, 0, columns_ - 1);
  const std::int64_t y = std::clamp<std::int64_t>(row / kSide, 0, rows_ - 1);
  return near_[static_cast<std::size_t>(y * columns_ + x)] != 0;
}

void KnownBlocks::MarkAround(int column, int row) {
  for (int y = std::max(row - 1, 0); y <= std::min(row + 1, rows_ - 1); ++y) {
    for (int x = std::max(column - 1, 0); x <= std::min(column + 1, columns_ - 1); ++x) {
      near_[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(x)] = 1;
    }
  }
}

}  // namespace enfilade::slam
