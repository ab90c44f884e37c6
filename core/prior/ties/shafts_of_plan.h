// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/graph/plans/plan_ties.h"
#include "core/prior/alignment/plan_transform.h"
#include "core/prior/plan/plan_graph.h"
#include "core/prior/ties/plan_frame.h"

namespace enfilade::prior {

// `is_seen`, of each wall, with the nearest wall of each corner of each shaft that has a name: what holds the shafts is
// part of the frame. As it is if no wall was seen.
std::vector<char> WithWallsOfShafts(const PlanGraph& plan, const PlanTransform& T_plan_sheet,
                                    std::vector<char> is_seen);

// The shafts with a name, each of their corners held by the nearest corner of the frame. Empty if the frame is.
std::vector<graph::ShaftInPlan> NamedShafts(const PlanGraph& plan, const PlanTransform& T_plan_sheet,
                                            const PlanFrame& frame);

}  // namespace enfilade::prior
