// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "CLI/CLI.hpp"
#include "absl/status/statusor.h"
#include "core/geometry/pose2.h"

namespace enfilade::cli {

// Where a log starts in an existing map, as people write it.
struct EntryOptions {
  std::string at;  // X,Y,YAW in metres and radians; empty: the log starts a new map
  // M,RAD: standard deviations of the position (along x and along y) and of the heading.
  std::string sigma = "0.3,0.15";
};

void AddEntryOptions(CLI::App& command, EntryOptions& options);

// Unset without --at. INVALID_ARGUMENT with the expected form.
absl::StatusOr<std::optional<PoseWithCovariance>> EntryOf(const EntryOptions& options);

}  // namespace enfilade::cli
