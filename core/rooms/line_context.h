// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "core/rooms/door_lines.h"
#include "core/rooms/ground.h"
#include "core/rooms/region_map.h"

namespace enfilade::rooms {

// What the other lines and the walls between a line's two regions say of it. A door is in a wall that goes on beside
// it, with the other room behind it (shared_walls.h); a corridor's doors lie in one straight wall, and many doors of a
// building are equally wide.
struct LineContext {
  double parted = 0.0;       // m, of the walls between the two regions
  double parted_wide = 0.0;  // m: the same, with the regions that lines which are rather open part from them
  double opened = 0.0;       // m, of all lines between the two regions
  double outline = 0.0;      // m, of the region with the shorter outline
  double rivals = 0.0;       // sum of the openness, each up to 3, of the other lines between the two regions
  double row = 0.0;          // doors in the same straight wall, each by its chance
  double alike = 0.0;        // share of the map's doors that are as wide
};

// Of each of the lines, along which the ground was cut; `outline` is not set.
std::vector<LineContext> ContextsOf(const GroundMap& ground, const CutGround& cut, const std::vector<DoorLine>& lines);

// As numbers, to which the odds are fitted (door_odds.h).
using ContextValues = std::array<double, 7>;
ContextValues ValuesOf(const LineContext& context);

}  // namespace enfilade::rooms
