// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace enfilade::rooms {

struct RoomOptions {
  double occupied_probability = 0.6;  // cells from here on are walls or furniture
  double free_probability = 0.4;      // cells up to here are free
  double hole = 0.4;                  // m: unknown cells between free ones up to this far apart count as free
  double clutter = 0.8;               // m: obstacles that stand free and are no longer than this are no walls
  double max_door = 4.0;              // m, the width of a door
  double min_room = 1.0;              // m^2; smaller pieces belong to the room that they are most open to
  // m^2; so do pieces of less than this that no robot has entered, such as a nook between furniture, or fits into: the
  // ground between two lines across the same doorway, for example.
  double small_room = 2.0;
  double robot_radius = 0.4;  // m
  // m: a space is one piece unless it narrows by this much, on each side, between two wider places.
  double narrowing = 0.1;
};

}  // namespace enfilade::rooms
