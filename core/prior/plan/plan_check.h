// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/status.h"
#include "core/prior/plan/plan_graph.h"

namespace enfilade::prior {

constexpr std::size_t kFewestWalls = 8;
constexpr std::size_t kMostWalls = 1'000'000;

// Whether this can be the plan of a building: besides Validate, INVALID_ARGUMENT with the counts if it has fewer walls
// than kFewestWalls, RESOURCE_EXHAUSTED if it has more than kMostWalls.
absl::Status CheckPlan(const PlanGraph& plan);

}  // namespace enfilade::prior
