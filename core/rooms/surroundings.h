// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <tuple>
#include <vector>

#include "core/rooms/door_lines.h"
#include "core/rooms/ground.h"
#include "core/rooms/line_context.h"
#include "core/rooms/region_map.h"

namespace enfilade::rooms {

// One side of a line, once the ground is cut along all lines. A doorway leads into something wider than itself; a line
// across a corridor does not, although other doors beside it may make it look so.
struct LineSide {
  double diameter = 0.0;    // m, of the largest circle in the region
  double area = 0.0;        // m^2, of the region
  double door_share = 0.0;  // of the region's outline: other lines that rather are doors
  double open_share = 0.0;  // of the region's outline: other lines that rather are open ground
  double outline = 0.0;     // m, of the region
  double wider = 0.0;       // m: as DoorEvidence::wider_before, other doors closed
};

using LineSides = std::array<LineSide, 2>;  // the side with the smaller circle first

struct Surroundings {
  LineSides sides;
  LineContext context;
};

// Of each of the lines, along which the ground was cut.
std::vector<Surroundings> SurroundingsOf(const GroundMap& ground, const CutGround& cut,
                                         const std::vector<DoorLine>& lines);

// A line's evidence (ValuesOf) and its surroundings as numbers, to which the odds are fitted (door_odds.h).
constexpr std::size_t kValuesOfSide = 6;
using SurroundedValues =
    std::array<double, std::tuple_size_v<DoorValues> + 2 * kValuesOfSide + std::tuple_size_v<ContextValues>>;
SurroundedValues ValuesOf(const DoorLine& line, const Surroundings& surroundings);

}  // namespace enfilade::rooms
