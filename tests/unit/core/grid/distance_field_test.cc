// SPDX-License-Identifier: Apache-2.0
#include "core/grid/distance_field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

namespace enfilade::grid {
namespace {

// By looking at each marked cell; negative: none is marked.
double NearestByLooking(const std::vector<std::uint8_t>& marked, int width, int cell) {
  double nearest = -1.0;
  for (int i = 0; i < static_cast<int>(marked.size()); ++i) {
    if (marked[static_cast<std::size_t>(i)] == 0) continue;
    const double d = std::hypot(i % width - cell % width, i / width - cell / width);
    nearest = nearest < 0.0 ? d : std::min(nearest, d);
  }
  return nearest;
}

TEST(DistancesTo, AreThoseToTheNearestMarkedCell) {
  constexpr int kWidth = 23;
  constexpr int kHeight = 17;
  std::mt19937 random(1);
  for (const double share : {0.01, 0.1, 0.5, 0.9, 1.0}) {
    std::vector<std::uint8_t> marked(kWidth * kHeight, 0);
    for (std::uint8_t& cell : marked) {
      cell = static_cast<double>(random()) <= share * static_cast<double>(std::mt19937::max()) ? 1 : 0;
    }
    marked[40] = 1;
    const DistanceField field = DistancesTo(marked, kWidth, kHeight);
    for (int cell = 0; cell < kWidth * kHeight; ++cell) {
      const auto i = static_cast<std::size_t>(cell);
      EXPECT_FLOAT_EQ(field.distance[i], static_cast<float>(NearestByLooking(marked, kWidth, cell)));
      const auto nearest = static_cast<int>(field.nearest[i]);
      ASSERT_LT(nearest, kWidth * kHeight);
      EXPECT_EQ(marked[static_cast<std::size_t>(nearest)], 1);
      const double d = std::hypot(nearest % kWidth - cell % kWidth, nearest / kWidth - cell / kWidth);
      EXPECT_FLOAT_EQ(field.distance[i], static_cast<float>(d));
    }
  }
}

TEST(DistancesTo, KnowsNoNearestCellIfNoneIsMarked) {
  const DistanceField field = DistancesTo(std::vector<std::uint8_t>(12, 0), 4, 3);
  for (const std::uint32_t nearest : field.nearest) EXPECT_EQ(nearest, DistanceField::kNone);
}

}  // namespace
}  // namespace enfilade::grid
