// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "absl/status/status.h"
#include "client/simulator/campus/campus.h"

namespace enfilade::simulator {

// Writes plans of every level into a folder, LEVEL.{geojson,svg,building.yaml}, LEVEL-filled.png and LEVEL-double.png,
// and what is true of them: LEVEL-truth.json (docs/simulator.md). A campus with one level has plan.* instead.
// `deform_seed`: as people would draw it (PlanDeformation); unset: as it is built, 25 pixels per metre.
// FAILED_PRECONDITION: a file cannot be written; INVALID_ARGUMENT: a level without walls, or too large to be drawn.
absl::Status WritePlanFiles(const Campus& campus, std::optional<std::uint64_t> deform_seed,
                            const std::filesystem::path& folder);

}  // namespace enfilade::simulator
