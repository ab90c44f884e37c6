// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "core/geometry/pose2.h"
#include "core/prior/alignment/plan_transform.h"
#include "core/prior/localization/particles.h"
#include "core/prior/localization/plan_field.h"

namespace enfilade::prior {

// Where a mode's robot is in a map in which its plan is placed. The covariance is the mode's: it does not contain how
// well the plan is placed. Unset: the mode has the plan mirrored and its placement has not, or the other way round.
std::optional<PoseWithCovariance> InMap(const PlanField& field, const PlanMode& mode, const PlanTransform& T_map_sheet);

}  // namespace enfilade::prior
