// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "core/prior/fit/fit_plan.h"
#include "core/prior/plan/plan_graph.h"

namespace enfilade::prior {

// What a plan's fit comes to, as JSON; lengths in m, angles in rad:
//   model, mirrored, rotation_rad, scale_x, scale_y (m per unit of the sheet), explained, contradicted, rival_ratio,
//   walls: by state (seen, unseen, contradicted, added) `count` and `length_m`;
//   doors: by state their count;
//   corners: by whether a wall that ends there was seen, how far they were moved from where the plan lies as a whole
//     (`moved_m`), and how well they are known (`sigma_m`): median, p95 and most;
//   stretch of the walls that were seen: median, least and most;
//   to_check: the walls that robots contradict and those that only they have seen, with their ends.
std::string WriteReport(const PlanGraph& plan, const PlanFit& fit);

}  // namespace enfilade::prior
