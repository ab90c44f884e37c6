// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "core/rooms/door_lines.h"
#include "core/rooms/ground.h"
#include "core/rooms/region_map.h"

namespace enfilade::rooms {

// What the first look makes of a line and of the map's other lines. Buildings differ, for example in how often what
// robots report is a door. Shares count one line more, whose chance is one half, so that a few do not decide.
struct FirstLooks {
  double own = 0.0;       // the line's openness
  double others = 0.0;    // the mean openness, each up to 3, of the other lines
  double reported = 0.5;  // the mean chance that another line which robots reported is a door
  double silent = 0.5;    // the same of those that robots crossed in silence
  double detected = 0.5;  // share of the others that are clearly doors: reported
  double doubtful = 0.5;  // share of the others: neither clearly open nor clearly a door
};

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
  FirstLooks looks;
};

// Of each of the lines, along which the ground was cut; `outline` is not set.
std::vector<LineContext> ContextsOf(const GroundMap& ground, const CutGround& cut, const std::vector<DoorLine>& lines);

// As numbers, to which the odds are fitted (door_odds.h).
using ContextValues = std::array<double, 13>;
ContextValues ValuesOf(const LineContext& context);

}  // namespace enfilade::rooms
