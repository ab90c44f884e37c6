// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/slam/slam_options.h"

namespace enfilade::slam {

// SLAM options from YAML: nested mappings with the names of slam_options.h, such as `loop: {drift_per_metre: 0.05}`.
// Options not given keep their defaults; an empty text gives the defaults. Messages begin with `name`, such as the file
// that the text comes from. INVALID_ARGUMENT, naming key and line: a key that does not exist or appears twice, a value
// of the wrong type, text that is not YAML, and what Validate rejects.
absl::StatusOr<SlamOptions> ParseSlamOptions(std::string_view yaml, std::string_view name = "");

// All options as YAML that ParseSlamOptions reads back to the same values.
std::string FormatSlamOptions(const SlamOptions& options);

}  // namespace enfilade::slam
