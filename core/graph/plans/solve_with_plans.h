// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "core/graph/graph_optimization.h"
#include "core/graph/graph_snapshot.h"
#include "core/graph/solved_graph.h"

namespace enfilade::graph {

// Solves the graph once more with its floor plans (GraphSnapshot::plans), given `without`, its optimum without them
// (OptimizeGraph). A plan is a structure that can be stretched, but hardly turned: its corners and walls are variables
// beside the maps (after M. Mielle et al., "The Auto-Complete Graph: merging and mutual correction of sensor and prior
// maps", 2019; here a corner has a turn of its own, so that a plan which is turned as a whole costs nothing). Each wall
// that a map has seen is measured across and in its direction, never along itself. So two maps that see the same wall
// are tied to each other, and a map that no link point joins to the root is posed by the plan.
//
// Link points are used as without plans: no plan overrules them. Those between maps that only plans join are judged as
// sightings and struts are: solved under Huber's kernel, then under one that narrows (dynamic covariance scaling), then
// switched off beyond the 99 % quantile of chi-squared (2 degrees of freedom for a sighting, 3 for a strut). What is
// switched off comes back at most once. If a wall that was seen would be stretched to less than 0.7 or more than 1.4 of
// its length, what was seen of the walls at one end of it is switched off for good (EdgesAroundStretched). A map that
// only plans join is posed if its position is known to a metre and its yaw to 5 degrees, in standard deviations; its
// covariance has 0.03 m and 0.2 degrees more, because SLAM bends maps.
//
// Shafts that plans of several levels have in common tie these (AddShafts). They are judged likewise, and are switched
// off first where link points no longer agree.
//
// A plan contradicts the maps if more than half of its sightings are switched off, if it would have to be bent too much
// (chi-squared of struts and sightings beyond twice its 0.999 quantile), if its shafts disagree with two plans of other
// levels and more (ContradictionOfShafts), or if link points no longer agree with the poses (0.999 quantile of
// chi-squared of all of them, or a tenth more than without plans, whatever is more). Such a plan is left out, and if
// none is left the result is `without`, but for `plans`.
absl::StatusOr<SolvedGraph> SolveWithPlans(const GraphSnapshot& graph, SolvedGraph without,
                                           const GraphOptimizationOptions& options = {});

}  // namespace enfilade::graph
