// SPDX-License-Identifier: Apache-2.0
#include "core/prior/plan/plan_check.h"

#include "core/base/error.h"

namespace enfilade::prior {

absl::Status CheckPlan(const PlanGraph& plan) {
  if (plan.walls.size() > kMostWalls) {
    return ResourceExhausted("{} walls, {} at most: choose layers, or divide the plan", plan.walls.size(), kMostWalls);
  }
  if (plan.walls.size() < kFewestWalls) return InvalidArgument("{} walls, {} needed", plan.walls.size(), kFewestWalls);
  return Validate(plan);
}

}  // namespace enfilade::prior
