// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "core/geometry/pose2.h"

namespace enfilade::cli {

// A pose in a map, as people write it: MAP,X,Y[,YAW] in metres and radians; without YAW it is 0. The map's name may
// hold commas if all three numbers follow.
struct PoseInMap {
  std::string map;  // display name, id or resource name
  Pose2 pose;
};

// INVALID_ARGUMENT with the expected form.
absl::StatusOr<PoseInMap> ParsePoseInMap(const std::string& text);

}  // namespace enfilade::cli
