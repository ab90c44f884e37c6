// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "client/simulator/world/world.h"
#include "core/geometry/pose2.h"
#include "perception/image/features.h"

namespace enfilade::testing {

// A corridor along x from 0 to `length`, drawn by the simulator: closed doors and posters on both walls, and an end
// wall with notices. Width, walls, doors and posters depend on the seed.
class Corridor {
 public:
  explicit Corridor(std::uint64_t seed);

  double length() const { return length_; }
  double middle() const { return width_ / 2.0; }  // y of its middle line

  // Features of what a robot's front camera sees there. `take` numbers the images: each has noise and exposure of its
  // own.
  perception::FeatureSet See(const Pose2& T_corridor_robot, std::uint64_t take) const;

 private:
  static simulator::Campus Draw(std::uint64_t seed, double length, double width);

  std::uint64_t seed_;
  double length_;
  double width_;
  simulator::World world_;
};

// Two views, and how the second robot stands relative to the first.
struct CorridorPair {
  perception::FeatureSet a;
  perception::FeatureSet b;
};

// What a robot sees that comes back to about the same place: up to 0.4 m along, 0.3 m aside, 0.15 rad turned.
CorridorPair SeeSamePlaceTwice(const Corridor& corridor, std::uint64_t seed);

// The same corridor seen from a place and from `ahead` m farther on, with the small changes of above aside and in yaw.
CorridorPair SeeFromAhead(const Corridor& corridor, double ahead, std::uint64_t seed);

}  // namespace enfilade::testing
