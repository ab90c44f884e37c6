// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "core/geometry/pose2.h"
#include "core/localization/localization_options.h"
#include "core/localization/scan_evidence.h"
#include "core/localization/searchable_map.h"

namespace enfilade::localization {

// A scan and where odometry had the robot. Odometry is continuous from scan to scan.
struct TrackedScan {
  QueryPoints points;
  Pose2 T_odom_robot;
};

// One possible drive of the robot through a map.
struct TrackedPose {
  PoseWithCovariance T_map_robot;     // at the last scan
  double log_likelihood = 0.0;        // of all scans, as independent beams (options.effective_beams, further_scan)
  double known_log_likelihood = 0.0;  // likewise
  ScanEvidence evidence;              // mean over the scans
};

// Follows the robot, which is about at `T_map_robot` at scan `seed`, through all scans: each pose is predicted by
// odometry and refined with the prediction as prior. Unset if known_log_likelihood falls below `give_up`: no further
// scan can raise it.
std::optional<TrackedPose> TrackPose(const SearchableMap& map, const std::vector<TrackedScan>& scans, std::size_t seed,
                                     const Pose2& T_map_robot, double give_up, const LocalizationOptions& options);

}  // namespace enfilade::localization
