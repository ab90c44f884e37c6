// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/prior/plan/plan_graph.h"

namespace enfilade::testing {

enum class WallStyle { kFilled, kDoubleLine };

// A small office on two sides of a corridor, with seven rooms, doors and a sloping wall, drawn with exact truth.
struct DrawnPlanOptions {
  WallStyle style = WallStyle::kFilled;
  double turn_deg = 0;
  double px_per_m = 25;
  double wall_m = 0.24;      // thickness
  double line_px = 2;        // of the pen that draws double lines, doors' leaves and furniture
  bool furniture = false;    // tables, doors' leaves with their arcs, letters
  bool dimensions = false;   // of two sides, with extension lines, ticks and digits
  bool plot = false;         // its boundary: a wide dash-dotted line around everything
  double shade_at_edge = 1;  // brightness of the paper at the right edge, 1 at the left
  bool bright_lines = false;
};

struct DrawnPlan {
  std::string png;
  prior::PlanGraph truth;  // in the picture's pixels: walls along their centre lines, and the doors between them
  int width = 0;
  int height = 0;
};

DrawnPlan DrawPlan(const DrawnPlanOptions& options = {});

}  // namespace enfilade::testing
