// SPDX-License-Identifier: Apache-2.0
#include "core/rooms/shared_walls.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace enfilade::rooms {
namespace {

// Calls visit(one, other) for each two regions that a wall of at most `thickest` cells parts on the way of `count`
// cells from `first` on, each `step` from the one before.
template <typename Visit>
void VisitWalls(const RegionMap& map, std::size_t first, std::size_t step, int count, int thickest, Visit&& visit) {
  std::int32_t last = RegionMap::kNone;
  int solid = 0;  // cells since the last region
  for (int i = 0; i < count; ++i) {
    const std::int32_t region = map.region[first + static_cast<std::size_t>(i) * step];
    if (region < 0) {
      ++solid;
      continue;
    }
    if (last >= 0 && last != region && solid > 0 && solid <= thickest) {
      visit(std::min(last, region), std::max(last, region));
    }
    last = region;
    solid = 0;
  }
}

}  // namespace

SharedWalls::SharedWalls(const GroundMap& ground, const RegionMap& map) : resolution_(ground.resolution) {
  constexpr double kThickest = 0.5;  // m
  const int thickest = static_cast<int>(kThickest / ground.resolution);
  const auto width = static_cast<std::size_t>(ground.width);
  for (int row = 0; row < ground.height; ++row) {
    VisitWalls(map, ground.index(0, row), 1, ground.width, thickest, [&](std::int32_t one, std::int32_t other) {
      crossings_[{one, other}].rows += 1.0;
    });
  }
  for (int column = 0; column < ground.width; ++column) {
    VisitWalls(map, ground.index(column, 0), width, ground.height, thickest, [&](std::int32_t one, std::int32_t other) {
      crossings_[{one, other}].columns += 1.0;
    });
  }
}

double SharedWalls::Between(std::int32_t one, std::int32_t other) const {
  const Crossings found = At(one, other);
  return std::hypot(found.rows, found.columns) * resolution_;
}

double SharedWalls::Between(std::span<const std::int32_t> some, std::span<const std::int32_t> others) const {
  Crossings sum;
  for (const std::int32_t one : some) {
    for (const std::int32_t other : others) {
      const Crossings found = At(one, other);
      sum.rows += found.rows;
      sum.columns += found.columns;
    }
  }
  return std::hypot(sum.rows, sum.columns) * resolution_;
}

SharedWalls::Crossings SharedWalls::At(std::int32_t one, std::int32_t other) const {
  const auto found = crossings_.find({std::min(one, other), std::max(one, other)});
  return found == crossings_.end() ? Crossings{} : found->second;
}

}  // namespace enfilade::rooms
