#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "core/geometry/pose2.h"

namespace enfilade::cli {

// A pose in a map, as people write it: MAP,X,Y[,YAW] in metres and radians. The map's name may hold commas where all
// three numbers follow.
struct Place {
  std::string map;
  Pose2 pose;
};

// INVALID_ARGUMENT saying what was expected.
absl::StatusOr<Place> ParsePlace(const std::string& text);

}  // namespace enfilade::cli
