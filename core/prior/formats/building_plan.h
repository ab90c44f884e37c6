// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/prior/formats/building_file.h"
#include "core/prior/plan/plan_graph.h"

namespace enfilade::prior {

// The walls and doors of one level, and the lifts that stop there, in units of its drawing: pixels of its picture.
PlanGraph PlanOfLevel(const Building& building, std::size_t level);

}  // namespace enfilade::prior
