// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "client/simulator/campus/campus.h"

namespace enfilade::simulator {

// Walls drawn as text: '#' is a cell of wall, a letter is a point of that name on free ground, anything else is free
// ground. The first row is the northernmost.
struct Drawing {
  std::vector<Wall> walls;  // sheets around the wall cells
  std::map<std::string, Eigen::Vector2d> points;
};

// `cell`: m; `origin`: the lower left corner. INVALID_ARGUMENT: no rows, two points of one name, a bad cell size.
absl::StatusOr<Drawing> ParseDrawing(std::string_view rows, double cell, const Eigen::Vector2d& origin);

}  // namespace enfilade::simulator
