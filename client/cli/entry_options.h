// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "CLI/CLI.hpp"
#include "absl/status/statusor.h"
#include "core/geometry/pose2.h"

namespace enfilade::cli {

// Where the robot is in a map that is there already, as people write it.
struct EntryOptions {
  std::string at;  // X,Y,YAW in metres and radians; empty: the map begins with the log
  std::string sigma =
      "0.3,0.15";  // M,RAD: standard deviations of the position, along x and along y, and of the heading
};

void AddEntryOptions(CLI::App& command, EntryOptions& options);

// Unset where nothing was said. INVALID_ARGUMENT saying what was expected.
absl::StatusOr<std::optional<PoseWithCovariance>> EntryOf(const EntryOptions& options);

}  // namespace enfilade::cli
