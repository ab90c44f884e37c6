// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/graph/plans/plan_ties.h"

namespace enfilade::graph {

// The share of the walls of the shorter of two plans that lies within about 1 m of walls of the other, 0 to 1, as both
// were placed in the world. Plans of the same rooms share most; plans of neighbouring wings the wall between them.
double ShareOfWalls(const PlanTies& a, const PlanTies& b);

}  // namespace enfilade::graph
