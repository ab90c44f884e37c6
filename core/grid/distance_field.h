// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

namespace enfilade::grid {

// For each cell the nearest marked cell, by the exact Euclidean distance between the cells' centres (A. Meijster, J.
// Roerdink, W. Hesselink, "A general algorithm for computing distance transforms in linear time", 2000).
struct DistanceField {
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  std::vector<float> distance;         // cells; very large if no cell is marked
  std::vector<std::uint32_t> nearest;  // the marked cell; kNone
};

// `marked`: row-major, width x height; marked cells are not 0.
DistanceField DistancesTo(const std::vector<std::uint8_t>& marked, int width, int height);

}  // namespace enfilade::grid
