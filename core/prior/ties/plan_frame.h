// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/graph/plans/plan_ties.h"
#include "core/prior/alignment/plan_transform.h"
#include "core/prior/plan/plan_graph.h"

namespace enfilade::prior {

// The struts that hold a plan together between the walls that were seen.
struct PlanFrame {
  std::vector<Eigen::Vector2d> corners;  // m, in the plan's frame (graph::PlanTies)
  std::vector<graph::PlanStrut> struts;
  std::vector<int> strut_of_wall;  // index; -1: the wall is not part of it
};

// The walls and doors of the plan, walls that end within 0.05 m of each other joined, without parts of it that no wall
// of `is_seen` is in and without ends that lead to none, and the shortest ways between parts that nothing joins. Empty
// if no wall is seen. Walls that are needed for something else count as seen. `T_plan_sheet`: to metres.
PlanFrame FrameOf(const PlanGraph& plan, const PlanTransform& T_plan_sheet, const std::vector<char>& is_seen);

}  // namespace enfilade::prior
