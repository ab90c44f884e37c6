// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/rooms/ground.h"

namespace enfilade::rooms {

// For each cell the nearest obstacle (wall or unknown; not clutter), by the exact Euclidean distance between the cells'
// centres (A. Meijster, J. Roerdink, W. Hesselink, "A general algorithm for computing distance transforms in linear
// time", 2000).
struct DistanceField {
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  std::vector<float> distance;         // cells; very large if there is no obstacle
  std::vector<std::uint32_t> nearest;  // the obstacle's cell; kNone
};

DistanceField DistancesToWalls(const GroundMap& ground);

}  // namespace enfilade::rooms
