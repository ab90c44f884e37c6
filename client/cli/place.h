// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/geometry/pose2.h"

namespace enfilade::cli {

// A pose in a map, as people write it: MAP,X,Y[,YAW] in metres and radians. The map's name may hold commas where all
// three numbers follow.
struct Place {
  std::string map;
  Pose2 pose;
};

// `count` finite numbers with commas between; unset where it is anything else.
std::optional<std::vector<double>> ParseNumbers(const std::string& text, std::size_t count);

// INVALID_ARGUMENT saying what was expected.
absl::StatusOr<Place> ParsePlace(const std::string& text);

}  // namespace enfilade::cli
