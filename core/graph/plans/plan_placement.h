// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/graph/graph_snapshot.h"
#include "core/graph/plans/shafts.h"
#include "core/graph/solved_graph.h"

namespace enfilade::graph {

// Where plans lie in the world by the maps that `solution` poses: each as the map has it that has seen most of it. Then
// those of which no such map has seen anything, by the shafts that they share with plans that have a place already
// (PlaceByShafts), again and again. Plans that get no place so are left out. The order is that in which they get one.
std::vector<PlacedPlan> PlacePlans(const GraphSnapshot& graph, const SolvedGraph& solution,
                                   const std::vector<const PlanInGraph*>& plans);

}  // namespace enfilade::graph
