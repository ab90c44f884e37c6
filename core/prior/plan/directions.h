// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/prior/plan/plan_graph.h"

namespace enfilade::prior {

struct WeightedDirection {
  Eigen::Vector2d direction;  // of a line: its opposite is the same
  double weight = 0;          // its length
};

// Up to four directions that many lines have: angles in [0, pi) from x to y, the one with the most weight first. Each
// has a tenth of all weight within 2 degrees.
std::vector<double> DominantDirections(const std::vector<WeightedDirection>& lines);
std::vector<double> DominantDirections(const PlanGraph& plan);

constexpr double kDirectionReach = 2.0 * 3.14159265358979323846 / 180.0;

double AngleOfLine(const Eigen::Vector2d& direction);  // in [0, pi)
double TurnOfLine(double a, double b);                 // from a to b as lines, in [-pi/2, pi/2]

}  // namespace enfilade::prior
