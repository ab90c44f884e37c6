// SPDX-License-Identifier: Apache-2.0
#include "core/rooms/region_map.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <vector>

namespace enfilade::rooms {
namespace {

constexpr int kWidth = 40;

std::vector<std::size_t> Rectangle(int left, int bottom, int columns, int rows) {
  std::vector<std::size_t> cells;
  for (int row = bottom; row < bottom + rows; ++row) {
    for (int column = left; column < left + columns; ++column) {
      cells.push_back(static_cast<std::size_t>(row * kWidth + column));
    }
  }
  return cells;
}

TEST(InscribedRadius, IsHalfTheShorterSideOfARectangle) {
  EXPECT_NEAR(InscribedRadius(Rectangle(3, 5, 12, 36), kWidth), 6.0, 0.5);
  EXPECT_NEAR(InscribedRadius(Rectangle(0, 0, 36, 7), kWidth), 3.5, 0.5);
}

TEST(InscribedRadius, OfTwoPiecesIsThatOfTheWider) {
  std::vector<std::size_t> cells = Rectangle(1, 1, 20, 4);
  const std::vector<std::size_t> other = Rectangle(25, 1, 10, 10);
  cells.insert(cells.end(), other.begin(), other.end());
  EXPECT_NEAR(InscribedRadius(cells, kWidth), 5.0, 0.5);
}

TEST(InscribedRadius, OfNothingIsNothing) { EXPECT_EQ(InscribedRadius({}, kWidth), 0.0); }

}  // namespace
}  // namespace enfilade::rooms
