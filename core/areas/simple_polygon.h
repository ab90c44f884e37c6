// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "absl/status/status.h"

namespace enfilade::areas {

// Sides that come nearer to one another than this, in m, touch. It exceeds the rounding of coordinates up to 1000 km,
// so that a simple polygon stays simple when it is turned into another frame.
constexpr double kTouchDistance = 1e-6;

// INVALID_ARGUMENT naming the corner or the two sides: fewer than three corners, a coordinate that is not finite or
// beyond `max_coordinate` (m), two corners at one place, sides that cross or touch. Side i leads from corner i to the
// next one. `corners`: the first one is not repeated at the end. Takes the square of their number.
absl::Status ValidateSimplePolygon(const std::vector<Eigen::Vector2d>& corners, double max_coordinate);

}  // namespace enfilade::areas
