// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/prior/plan/plan_graph.h"
#include "perception/plan/walls/stroke_graph.h"

namespace enfilade::perception {

// Walls from strokes. Strokes that go on straight through joints are fitted as one line. Corners are where these lines
// intersect, as the skeleton is bent there; ends lie half a width beyond the skeleton's. Lines within 2 degrees of a
// direction of many walls take it if that moves them by less than a pixel. The walls are planar.
prior::PlanGraph AssembleWalls(const StrokeGraph& walls);

}  // namespace enfilade::perception
