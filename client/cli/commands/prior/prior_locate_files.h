// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/time.h"
#include "core/prior/localization/plan_field.h"
#include "core/prior/localization/submap_tracking.h"
#include "nlohmann/json.hpp"

namespace enfilade::cli {

// Where the robot was at the end, and the submaps (docs/plan_localization.md).
nlohmann::json LocatedReport(const prior::PlanField& field, const prior::PlanDrive& drive, double seconds);
// After each look; `times`: of each look.
nlohmann::json LocatedSteps(const prior::PlanField& field, const prior::PlanDrive& drive,
                            const std::vector<TimeNs>& times);
// For people.
std::string DescribeLocated(const prior::PlanField& field, const prior::PlanDrive& drive, double seconds);

// The plan's walls in black, the particles at the end in orange, the way of the heaviest mode (grey, green where it is
// confident), and the 95 % ellipses of its position, red those of the modes at the end. PNG.
absl::StatusOr<std::string> PlotLocated(const prior::PlanField& field, const prior::PlanDrive& drive);

}  // namespace enfilade::cli
