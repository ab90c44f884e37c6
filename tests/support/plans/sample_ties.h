// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/graph/plans/plan_ties.h"

namespace enfilade::graph {

// Ties with one of everything: three corners, a wall and a door, two maps, what one of them has seen of the wall, and a
// lift.
inline PlanTies SampleTies() {
  PlanTies ties;
  ties.corners = {{0, 0}, {4, 0}, {4, 3}};
  ties.struts = {{0, 1, 7}, {1, 2, -1}};
  ties.maps = {{MapId("a"), {1, 2, 0.5}}, {MapId("b"), {}}};
  ties.sightings = {{.strut = 0,
                     .map = MapId("a"),
                     .T_map_line = {1, 2, 3},
                     .along = 0.5,
                     .length = 2,
                     .across_sigma = 0.05,
                     .yaw_sigma = 0.01}};
  ties.shafts = {{.name = "lift", .is_lift = true, .outline = {{1, 1}, {2, 1}, {2, 2}}, .held_by = {0, 1, 2}}};
  ties.corner_sigma = 0.2;
  ties.stretch_sigma = 0.05;
  return ties;
}

}  // namespace enfilade::graph
