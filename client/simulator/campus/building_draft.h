// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "client/simulator/campus/campus.h"
#include "client/simulator/campus/random_building.h"
#include "core/base/noise.h"

// The steps that make a random building. Each draws from the same noise, so their order is part of the result.
namespace enfilade::simulator {

struct Rect {
  double x = 0.0, y = 0.0, width = 0.0, height = 0.0;

  bool Holds(const Eigen::Vector2d& p, double margin) const {
    return p.x() >= x + margin && p.x() <= x + width - margin && p.y() >= y + margin && p.y() <= y + height - margin;
  }
};

// An open door that the route may pass.
struct PassableDoor {
  std::size_t door;  // in the campus
  int spaces[2];
  Eigen::Vector2d normal;  // from spaces[0] to spaces[1]
  int used = 0;
};

struct BuildingDraft {
  BuildingDraft(std::uint64_t seed, const BuildingOptions& building_options);

  // Of the robot, which PlanRoute adds.
  const std::vector<RouteStep>& route() const { return campus.robots.back().route; }
  const Rect& space(int index) const { return spaces[static_cast<std::size_t>(index)]; }

  const BuildingOptions options;
  Noise noise;
  Campus campus;
  std::vector<Rect> spaces;  // as campus.areas
  std::vector<PassableDoor> passable;
};

// A corridor with rooms on both sides, a hall at its end and a yard, with doors between them.
void LayOutSpaces(BuildingDraft& draft);

// The robot's route through as many doors as the options ask for.
void PlanRoute(BuildingDraft& draft);

// Boxes, narrow places and people that leave the route free. Removes door leaves that block it.
void Furnish(BuildingDraft& draft);

// Last, with noise of its own, so that the building and the first robot's route do not depend on it: the robot
// "robot2", which starts in the same space and takes another way around the furniture, and the ways back from the ends
// of both routes.
void AddSecondRobot(BuildingDraft& draft, std::uint64_t seed);

}  // namespace enfilade::simulator
