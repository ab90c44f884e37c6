// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "absl/status/status.h"
#include "core/sensor/scan_pairing.h"

namespace enfilade::prior {

struct DriveScanRules {
  int min_hits = 30;          // that a scan has at least
  double longest_step = 3.0;  // m from scan to scan: further apart they have little in common
  double fastest = 10.0;      // m/s
  double least_distance = 0;  // m over all scans
};

// Whether the scans can be those of one robot on one drive. INVALID_ARGUMENT, naming the scan: there are none; one
// without odometry, or what sensor::Validate refuses; one that was taken before the one before it; odometry that
// jumps, as between the scans of two robots; no scan has min_hits; the robot drove less than least_distance.
absl::Status CheckDriveScans(const std::vector<sensor::PairedScan>& scans, const DriveScanRules& rules);

}  // namespace enfilade::prior
