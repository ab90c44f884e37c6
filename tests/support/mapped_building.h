// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "client/simulator/campus/campus.h"
#include "core/geometry/pose2.h"
#include "core/grid/occupancy_grid.h"

namespace enfilade::testing {

// A robot's map of a simulated building: its scans, with their noise, drawn where it truly was. `T_campus_map`: the
// frame of the map, anywhere. The part of the drive from `begin` to `end`, shares of its scans.
struct DrivePart {
  std::string robot = "robot";
  double begin = 0.0;
  double end = 1.0;
  std::uint64_t seed = 1;  // of the sensors
};
grid::OccupancyGrid MapOfDrive(const simulator::Campus& campus, const DrivePart& part, const Pose2& T_campus_map);

// Two maps of a random building, in frames of their own: one robot has made the first in the earlier part of its drive,
// and another one's noise the second in the later part. They share rooms and the corridor between.
struct MapPair {
  grid::OccupancyGrid a;
  grid::OccupancyGrid b;
  Pose2 T_a_b;
};
MapPair TwoMapsOfABuilding(std::uint64_t seed);

}  // namespace enfilade::testing
