// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "client/simulator/campus/campus.h"

namespace enfilade::simulator {

struct BuildingOptions {
  int passages = 12;               // that the robot's route makes
  double min_width = 0.7;          // m, of doors
  double max_width = 2.0;          // m
  double max_incidence = 0.96;     // rad (55 deg): how obliquely doors are passed if they are wide enough
  double beside_wall = 0.25;       // share of doors with a jamb in the room's corner
  double glass_panel = 0.2;        // share of doors with a pane beside them
  double leaf = 0.4;               // share of doors whose leaf stands open in the room
  double robot_half_width = 0.25;  // m: must fit between the jambs
  double clutter = 0.12;           // boxes per square metre
  double people = 0.02;            // per square metre
  double narrows = 0.5;            // share of rooms in which the route leads between two boxes
};

// A building generated from a seed: a corridor with rooms on both sides, a hall at its end and a yard; doors of all
// widths, open, closed and glazed, some in corners, some with their leaf in the room; furniture, narrow places that are
// not doors, people. The robot "robot" drives through doors at all angles; "robot2" starts in the same area and takes
// another way. Both can drive several laps. The same seed and options give the same building.
Campus RandomBuilding(std::uint64_t seed, const BuildingOptions& options = {});

}  // namespace enfilade::simulator
