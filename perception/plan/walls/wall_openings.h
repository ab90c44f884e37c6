// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/prior/plan/plan_graph.h"

namespace enfilade::perception {

// A gap in the walls that may be a door: between two wall ends that face each other, or between an end and the side of
// a wall.
struct Opening {
  int end = 0;         // the corner where a wall ends freely
  int other_end = -1;  // the same where the gap ends; -1: that is a wall's side
  Eigen::Vector2d from = Eigen::Vector2d::Zero();
  Eigen::Vector2d to = Eigen::Vector2d::Zero();
  // How little it looks like a door, whatever its width: squared standard deviations, as twice a negative log
  // likelihood. 0: two ends in one line.
  double strangeness = 0;

  double Width() const { return (to - from).norm(); }
};

// All gaps up to `reach` wide, with no wall in between, between ends that point at each other or at a wall's side as
// well as in a drawing by hand, whose corners lie a fifth of a gap aside. An end may be in several. Of plans with so
// many walls within the reach of each other that this would take long, only the narrower ones.
std::vector<Opening> FindOpenings(const prior::PlanGraph& plan, double reach);

}  // namespace enfilade::perception
