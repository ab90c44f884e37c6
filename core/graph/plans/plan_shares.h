// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "absl/status/statusor.h"
#include "core/graph/joint_graph.h"
#include "core/graph/plans/joint_plans.h"
#include "core/graph/plans/joint_shafts.h"
#include "core/graph/solved_graph.h"

namespace enfilade::graph {

// What each plan contributes to the covariance of the map at a node, given the graph at its optimum.
absl::StatusOr<std::vector<PlanShare>> SharesOf(const JointGraph& joint, const std::vector<PlanPart>& parts,
                                                const JointShafts& shafts, std::size_t node);

}  // namespace enfilade::graph
