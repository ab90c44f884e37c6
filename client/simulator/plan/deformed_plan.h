// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "core/prior/plan/plan_graph.h"

namespace enfilade::simulator {

// How a plan of a building differs from the building: drawn by hand, from memory, before it was changed.
struct PlanDeformation {
  std::uint64_t seed = 1;
  double px_per_m = 25.0;  // before the scales below
  // Each axis of the sheet has a scale of its own.
  double least_scale = 0.8;
  double most_scale = 1.25;
  double stretch = 0.03;    // the standard deviation of the logarithm by which each strip between two walls is too wide
  double jitter = 0.15;     // m: of each corner, in x and y
  double left_out = 0.1;    // share of the walls that is not drawn
  double invented = 0.1;    // walls that are not there, by the number of all
  double door_shift = 0.3;  // m: doors are drawn up to this far aside
  double mirrored = 0.1;    // the chance that it is
  bool turned = true;       // by any angle

  // Nothing is wrong with the plan.
  static PlanDeformation None() {
    return {.least_scale = 1,
            .most_scale = 1,
            .stretch = 0,
            .jitter = 0,
            .left_out = 0,
            .invented = 0,
            .door_shift = 0,
            .mirrored = 0,
            .turned = false};
  }
};

struct DeformedPlan {
  prior::PlanGraph graph;                // px; its scale is not told
  std::vector<Eigen::Vector2d> corners;  // m, campus frame: where each of the graph's corners is in the building
  std::vector<bool> invented;            // of each wall
  std::vector<std::array<Eigen::Vector2d, 2>> left_out;  // m, campus frame
  bool mirrored = false;
};

// `built`: PlanOf.
DeformedPlan Deform(const prior::PlanGraph& built, const PlanDeformation& deformation);

}  // namespace enfilade::simulator
