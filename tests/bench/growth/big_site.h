// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/bench/support/bench_system.h"

namespace enfilade::bench {

constexpr double kRoomSide = 8.0;  // m

// Where room `i` of a site with `maps` rooms lies: they form a square.
struct RoomPlace {
  double x = 0.0;  // m, in the world
  double y = 0.0;
};
RoomPlace PlaceOfRoom(int i, int maps);

// Sites "size-MAPS-0", "size-MAPS-1", ... of `maps` rooms each, "room-0" and so on, with a door to the room on the
// right and one to the room above. They are written straight into the database while the server is away, with their
// poses.
void AddSites(BenchSystem& system, int sites, int maps);

}  // namespace enfilade::bench
