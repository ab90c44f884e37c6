// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "absl/status/status.h"
#include "client/simulator/campus/campus.h"
#include "client/simulator/plan/deformed_plan.h"

namespace enfilade::simulator {

// Writes plans of every level into a folder, LEVEL.{geojson,svg,building.yaml}, LEVEL-filled.png and LEVEL-double.png,
// and what is true of them: LEVEL-truth.json (docs/simulator.md). A campus with one level has plan.* instead.
// `deformation`: how wrong they are; None: as the campus is built.
// FAILED_PRECONDITION: a file cannot be written; INVALID_ARGUMENT: a level without walls, or too large to be drawn.
absl::Status WritePlanFiles(const Campus& campus, const PlanDeformation& deformation,
                            const std::filesystem::path& folder);

}  // namespace enfilade::simulator
