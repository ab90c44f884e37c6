// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "core/geometry/pose2.h"
#include "core/localization/localization_options.h"
#include "core/localization/pose_tracking.h"
#include "core/sensor/laser_scan.h"

namespace enfilade::localization {

// A scan of the robot that is to be located.
struct QueryScan {
  sensor::LaserScan scan;
  std::optional<Pose2> T_odom_robot;  // needed if there are several scans
};

// The last scan, and earlier ones at least scan_spacing apart; max_scans at most, evenly chosen. INVALID_ARGUMENT: no
// scans; none of the chosen ones has min_hits; naming the scan: one of several without odometry, what
// sensor::Validate refuses.
absl::StatusOr<std::vector<TrackedScan>> SelectScans(const std::vector<QueryScan>& scans,
                                                     const LocalizationOptions& options);

// Those to search the maps for: the first, a middle and the last of those with min_hits.
std::vector<std::size_t> ScansToSearch(const std::vector<TrackedScan>& scans, const LocalizationOptions& options);

}  // namespace enfilade::localization
