// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "absl/status/statusor.h"
#include "client/simulator/campus/campus.h"

namespace enfilade::simulator {

// A campus from its text (docs/simulator.md). INVALID_ARGUMENT with the line: not valid YAML, an unknown key, a value
// of the wrong type or outside its range. INVALID_ARGUMENT with the part: what Validate refuses.
absl::StatusOr<Campus> ParseCampus(std::string_view yaml);

}  // namespace enfilade::simulator
