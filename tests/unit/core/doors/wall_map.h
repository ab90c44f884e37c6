// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/doors/local_map.h"
#include "core/sensor/laser_scan.h"

namespace enfilade::doors {

struct Segment {
  Eigen::Vector2d a;
  Eigen::Vector2d b;
};

// What a scanner at `from`, looking east, sees of walls without thickness, with 1440 beams all around.
inline sensor::LaserScan ScanOf(const std::vector<Segment>& walls, const Eigen::Vector2d& from) {
  sensor::LaserScan scan;
  scan.angle_min = -M_PI;
  scan.angle_increment = M_PI / 720.0;
  scan.range_max = 30.0F;
  for (int i = 0; i < 1440; ++i) {
    const double angle = scan.angle(static_cast<std::size_t>(i));
    const Eigen::Vector2d ray(std::cos(angle), std::sin(angle));
    double nearest = INFINITY;
    for (const Segment& wall : walls) {
      const Eigen::Vector2d edge = wall.b - wall.a;
      const Eigen::Vector2d to = wall.a - from;
      const double cross = ray.x() * edge.y() - ray.y() * edge.x();
      if (std::abs(cross) < 1e-12) continue;
      const double range = (to.x() * edge.y() - to.y() * edge.x()) / cross;
      const double along = (to.x() * ray.y() - to.y() * ray.x()) / cross;
      if (range > 0.0 && along >= 0.0 && along <= 1.0) nearest = std::min(nearest, range);
    }
    scan.ranges.push_back(static_cast<float>(nearest));
  }
  return scan;
}

// The map that scans from these places make of the walls.
inline LocalMap MapOf(const std::vector<Segment>& walls, const std::vector<Eigen::Vector2d>& places) {
  LocalMap map(0.05, 5.0);
  for (const Eigen::Vector2d& from : places) map.Add(ScanOf(walls, from), {from.x(), from.y(), 0.0});
  return map;
}

inline const std::vector<Eigen::Vector2d> kWayEast = {{-1.5, 0.02}, {-1.0, 0.01}, {-0.5, 0.0}, {0.5, 0.0}, {1.0, 0.01}};

}  // namespace enfilade::doors
