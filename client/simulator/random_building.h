// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "client/simulator/campus.h"

namespace enfilade::simulator {

struct BuildingOptions {
  int passages = 12;               // that the robot's route makes
  double min_width = 0.7;          // m, of doors
  double max_width = 2.0;          // m
  double max_incidence = 0.96;     // rad (55 deg): how obliquely doors are driven through, where they are wide enough
  double beside_wall = 0.25;       // share of doors with a jamb at the room's corner
  double glass_panel = 0.2;        // share of doors with a pane beside them
  double leaf = 0.4;               // share of doors whose leaf stands open in the room
  double robot_half_width = 0.25;  // m: what must fit through
  double clutter = 0.12;           // boxes per square metre
  double people = 0.02;            // per square metre
  double narrows = 0.5;  // share of rooms in which the way leads between two boxes; and cupboards in corridors
};

// A building made up from a seed: a corridor with rooms on both sides, a hall at its end and a yard; doors of all
// widths open, closed and glazed, some at corners, some with their leaf in the way; furniture, narrow places that are
// no doors, people. One robot, "robot", drives through doors at all angles. The same seed and options give the same
// building.
Campus RandomBuilding(std::uint64_t seed, const BuildingOptions& options = {});

}  // namespace enfilade::simulator
