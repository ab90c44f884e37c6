// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/cli/command.h"
#include "client/sources/log_reader.h"
#include "core/base/time.h"
#include "core/prior/localization/submap_tracking.h"

namespace enfilade::cli {

// A recorded drive as SLAM maps it.
struct MappedDrive {
  std::vector<TimeNs> times;            // of each look
  std::vector<prior::DriveLook> looks;  // the keyframes with their scans, in order of time
  std::vector<prior::DriveSubmap> submaps;
};

// Maps the log to its end, with a progress bar. INVALID_ARGUMENT: no scan could be mapped; errors of the reader.
absl::StatusOr<MappedDrive> MapDrive(const Globals& globals, const std::string& log,
                                     const sources::LogOptions& reading);

}  // namespace enfilade::cli
