// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/prior/plan/plan_graph.h"

namespace enfilade::perception {

// Openings (wall_openings.h) that look like doors: each wall's end has at most one, and they are about as wide as the
// others, 0.6 to 2.2 m if the plan has a scale; else `diagonal` of the sheet limits them.
std::vector<prior::PlanDoor> FindDoors(const prior::PlanGraph& plan, double diagonal);

}  // namespace enfilade::perception
