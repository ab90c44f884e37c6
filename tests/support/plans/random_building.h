// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <random>
#include <vector>

#include "core/prior/plan/plan_graph.h"
#include "tests/support/plans/drawn_building.h"

namespace enfilade::prior {

// What a building is drawn within, m.
struct BuildingShell {
  double width = 44;
  double depth = 24;
};

// A building at 20 units a metre: a corridor with rooms of random widths, and doors, on both sides; some rooms are
// divided. Other seeds with the same shell are other floors of the building.
inline PlanGraph RandomBuilding(unsigned seed, const BuildingShell& shell) {
  std::mt19937 random(seed);
  const auto between = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random() % 1000) / 1000;
  };
  PlanGraph plan;
  const auto wall = [&](double x0, double y0, double x1, double y1) {
    DrawWall(plan, 20 * Eigen::Vector2d(x0, y0), 20 * Eigen::Vector2d(x1, y1));
  };
  const double width = shell.width, depth = shell.depth;
  wall(0, 0, width, 0), wall(width, 0, width, depth), wall(width, depth, 0, depth), wall(0, depth, 0, 0);
  const double corridor = between(0.3, 0.6) * depth;
  const double corridor_width = between(1.8, 3);
  for (const bool lower : {false, true}) {
    const double y = lower ? corridor + corridor_width : corridor;
    const double end = lower ? depth : 0;
    for (double x = 0; x < width;) {
      double next = x + between(2.8, 8);
      if (next > width - 2.8) next = width;
      const double door = between(x + 0.5, next - 1.5);
      wall(x, y, door, y), wall(door + 1, y, next, y);
      if (next < width) wall(next, y, next, end);
      const double middle = y + between(0.35, 0.65) * (end - y);
      if (random() % 3 == 0) wall(x, middle, next - 1, middle);
      x = next;
    }
  }
  return plan;
}

inline BuildingShell RandomShell(unsigned seed) {
  std::mt19937 random(seed);
  return {30.0 + random() % 30, 16.0 + random() % 14};
}

}  // namespace enfilade::prior
