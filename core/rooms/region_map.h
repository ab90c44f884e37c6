// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/rooms/door_candidate.h"
#include "core/rooms/ground.h"

namespace enfilade::rooms {

// The open ground cut along lines: its connected pieces.
struct RegionMap {
  static constexpr std::int32_t kNone = -1;

  std::vector<std::int32_t> region;  // of each cell; kNone: not open
  std::vector<std::int64_t> sizes;   // cells of each region
};

// The two regions on either side of a line; kNone: none.
struct Sides {
  std::int32_t before = RegionMap::kNone;
  std::int32_t behind = RegionMap::kNone;
};

struct CutGround {
  RegionMap map;
  std::vector<Sides> sides;  // of each line
};

// Cells on a line belong to the nearest region, and so do those beside walls: a hole of one or two cells in a wall
// joins nothing.
CutGround CutAlong(const GroundMap& ground, const DistanceField& field, std::span<const DoorCandidate> lines);

// Calls visit(cell) for the open cells of a line without gaps at corners.
template <typename Visit>
void VisitLineCells(const GroundMap& ground, const DoorCandidate& line, Visit&& visit) {
  const int steps = static_cast<int>(std::ceil(3.0 * line.length())) + 1;
  for (int i = 0; i <= steps; ++i) {
    const Eigen::Vector2d p = line.a + (line.b - line.a) * (static_cast<double>(i) / steps);
    const auto x = static_cast<int>(std::lround(p.x()));
    const auto y = static_cast<int>(std::lround(p.y()));
    if (ground.IsOpen(x, y)) visit(ground.index(x, y));
  }
}

// The radius in cells of the largest circle within the cells `cells`, of a grid that is `width` cells wide: obstacles
// and all other cells bound it.
double InscribedRadius(std::span<const std::size_t> cells, int width);

}  // namespace enfilade::rooms
