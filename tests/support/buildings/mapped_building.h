// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "client/simulator/campus/campus.h"
#include "core/geometry/pose2.h"
#include "core/grid/occupancy_grid.h"

namespace enfilade::testing {

// How a map of a simulated drive is made.
enum class Mapping {
  kTruePoses,  // its scans, with their noise, drawn where the robot truly was: the map's frame is exactly known
  kSlam,       // by odometry and scans, as the server maps: the map is bent by a few centimetres
};

// The part of a robot's drive from `begin` to `end`, shares of its scans.
struct DrivePart {
  std::string robot = "robot";
  double begin = 0.0;
  double end = 1.0;
  std::uint64_t seed = 1;  // of the sensors
};

struct MapOfPart {
  grid::OccupancyGrid grid;
  Pose2 T_campus_map;  // with SLAM where the part begins, else as asked for
};
MapOfPart MapDrive(const simulator::Campus& campus, const DrivePart& part, Mapping mapping, const Pose2& T_campus_map);

// Two maps of a random building, in frames of their own, of the earlier and the later part of a drive, each with noise
// of its own. They share rooms and the corridor between.
struct MapPair {
  grid::OccupancyGrid a;
  grid::OccupancyGrid b;
  Pose2 T_a_b;
};
MapPair TwoMapsOfABuilding(std::uint64_t seed, Mapping mapping = Mapping::kTruePoses);

}  // namespace enfilade::testing
