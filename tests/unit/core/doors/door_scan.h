// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>

#include "core/geometry/pose2.h"
#include "core/sensor/laser_scan.h"

namespace enfilade::doors {

// A full turn of half-degree beams at 5 m, with posts 1.5 m away of 40 degrees on both sides of a gap of `gap` degrees
// in direction `towards`.
inline sensor::LaserScan DoorScan(double towards, double gap) {
  sensor::LaserScan scan;
  scan.angle_min = -M_PI;
  scan.angle_increment = kDegree / 2.0;
  scan.range_max = 100.0F;
  for (int i = 0; i < 720; ++i) {
    const double off = std::abs(WrapAngle(scan.angle(static_cast<std::size_t>(i)) - towards)) / kDegree;
    scan.ranges.push_back(off > gap / 2.0 && off < gap / 2.0 + 40.0 ? 1.5F : 5.0F);
  }
  return scan;
}

}  // namespace enfilade::doors
