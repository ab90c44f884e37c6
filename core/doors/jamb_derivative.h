// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/doors/door_options.h"
#include "core/sensor/laser_scan.h"

namespace enfilade::doors {

// D of beam j: half the difference of the ranges half_window after and before it. The window is clamped to the scan. No
// return counts as infinitely far; D is NaN if either beam is unknown or both are infinite.
std::vector<double> ScanDerivative(const sensor::LaserScan& scan, const DerivativeOptions& options);

// The two posts of a door in one scan.
struct JambPair {
  double right = 0.0;  // rad, bearings in the robot's frame, by the beams at which D crosses the threshold
  double left = 0.0;
  double opening = 0.0;  // rad between them, through the gap
};

struct JambSearch {
  std::optional<JambPair> jambs;
  bool sector_in_view = false;  // the scanner sees the sector
  std::string reason;           // why there are none, or the opening
};

// Ahead: |bearing| <= front_sector; D rises above the threshold at the right post, falls below its negative at the
// left.
JambSearch FindJambsAhead(const sensor::LaserScan& scan, const DerivativeOptions& options);
// Behind: |bearing| >= back_sector, seen through the scan's seam at +-180 degrees.
JambSearch FindJambsBehind(const sensor::LaserScan& scan, const DerivativeOptions& options);

}  // namespace enfilade::doors
