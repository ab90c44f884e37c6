// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/slam/slam_options.h"

namespace enfilade::slam {

// SLAM options from YAML: nested maps with the names of slam_options.h, e.g. `loop: {drift_per_metre: 0.05}`. What is
// not named keeps its default; an empty text gives the defaults. INVALID_ARGUMENT naming the key and the line: a key
// that does not exist or comes twice, a value of another type, text that is no YAML, and what Validate refuses.
absl::StatusOr<SlamOptions> ParseSlamOptions(std::string_view yaml);

// All options as YAML that ParseSlamOptions reads back to the same values.
std::string FormatSlamOptions(const SlamOptions& options);

}  // namespace enfilade::slam
