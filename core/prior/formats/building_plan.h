// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "core/prior/formats/building_file.h"
#include "core/prior/plan/plan_graph.h"

namespace enfilade::prior {

// The walls and doors of one level, and the lifts that stop there, in units of its drawing: pixels of its picture.
PlanGraph PlanOfLevel(const Building& building, std::size_t level);

// A building.yaml of Open-RMF's traffic editor with this plan as its only level: walls, doors, and the measured line
// that gives its scale.
std::string WriteBuildingPlan(const PlanGraph& plan, const std::string& level, double metres_per_unit);

}  // namespace enfilade::prior
