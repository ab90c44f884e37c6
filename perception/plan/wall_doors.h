// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/prior/plan/plan_graph.h"

namespace enfilade::perception {

// Openings between two wall ends that face each other in one line, or between an end and the wall that it points at,
// as wide as a door: 0.6 to 2.2 m by the plan's scale; if that is unknown, 0.5 to 2 times the width that most openings
// have. `diagonal` of the sheet limits them, too.
std::vector<prior::PlanDoor> FindDoors(const prior::PlanGraph& plan, double diagonal);

}  // namespace enfilade::perception
