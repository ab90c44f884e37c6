// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/prior/plan/plan_graph.h"

namespace enfilade::prior {

// `rooms` with the names of those rooms of `named` that have a point of theirs inside; of several the largest one's.
std::vector<PlanRoom> WithNamesOf(const std::vector<PlanRoom>& named, std::vector<PlanRoom> rooms);

// Of a closed outline; positive if it turns from x to y.
double AreaOf(const std::vector<Eigen::Vector2d>& outline);

// A point well inside a closed outline: the middle of the widest place at half its height.
Eigen::Vector2d InsideOf(const std::vector<Eigen::Vector2d>& outline);

}  // namespace enfilade::prior
