// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "client/simulator/campus/campus.h"
#include "core/base/noise.h"

// What the random buildings of suites and of halls are made of. Each step draws from the same noise, so the order of
// the steps is part of the result.
namespace enfilade::simulator {

// A rectangle of the ground in a frame of its own: u along its front, v away from it, at right angles.
struct Plot {
  Eigen::Vector2d origin;
  Eigen::Vector2d u;
  Eigen::Vector2d v;
  double width;  // m, along u
  double depth;  // m, along v

  Eigen::Vector2d At(double along, double away) const { return origin + along * u + away * v; }
  std::vector<Eigen::Vector2d> Outline() const {  // from u = v = 0, along u first
    return {At(0.0, 0.0), At(width, 0.0), At(width, depth), At(0.0, depth)};
  }
};

// A wall that a door is cut into.
struct SolidWall {
  Eigen::Vector2d from;
  Eigen::Vector2d to;
  double widest;        // m, of the door
  double closed = 0.0;  // how likely the door is closed,
  double leaf = 0.0;    // and how likely its leaf stands on the side `into`, hinged away from `from`
  Eigen::Vector2d into = Eigen::Vector2d::Zero();
  double narrowest = 0.75;  // m, of the door
};

class PlottedBuilding {
 public:
  // `noise_seed` is that of this building alone; its walls' texture is drawn from `seed`.
  PlottedBuilding(const std::string& name, std::uint64_t seed, std::uint64_t noise_seed);

  // The outline may run either way round.
  void AddArea(const std::string& id, AreaKind kind, std::vector<Eigen::Vector2d> outline);
  // Half of the doors stand at an end of their wall.
  void AddDoor(const SolidWall& wall);
  // The same; where the wall is long enough, some are double doors of 1.8 to 3.2 m, which stand open.
  void AddDoorOrDouble(const SolidWall& wall);
  // With its lower corner at u, v of the plot. No box is added where a door is near or the way past another box would
  // be narrow.
  void AddBox(const Plot& plot, double u, double v, double width, double depth, double top);
  // A few pieces at the walls: beds, desks, wardrobes.
  void Furnish(const Plot& plot);

  Noise noise;
  Campus campus;
};

}  // namespace enfilade::simulator
