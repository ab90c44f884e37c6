// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

namespace enfilade::simulator {

using Barrier = std::pair<Eigen::Vector2d, Eigen::Vector2d>;

struct FloorArea {
  std::vector<Eigen::Vector2d> outline;  // counter-clockwise, along cells of 0.1 m
  double size = 0.0;                     // m^2
  Eigen::Vector2d inside{0.0, 0.0};      // its point that is farthest from the barriers
};

// The pieces of at least `least` m^2 into which barriers divide the plane, from the largest; without the one that is
// open to infinity.
std::vector<FloorArea> DivideFloor(const std::vector<Barrier>& barriers, double least);

}  // namespace enfilade::simulator
