// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>

#include "absl/status/statusor.h"
#include "core/prior/plan/plan_graph.h"

namespace enfilade::simulator {

enum class LineStyle {
  kFilled,  // walls are solid strokes
  kDouble,  // walls are two lines
};

// The plan as people draw it: its walls black on white. INVALID_ARGUMENT: more than 64 million pixels.
absl::StatusOr<std::string> DrawSheet(const prior::PlanGraph& plan, LineStyle style);

// px, to the edge of the wall's rectangle, negative within.
double DistanceToInk(const Eigen::Vector2d& point, const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                     double thickness);

}  // namespace enfilade::simulator
