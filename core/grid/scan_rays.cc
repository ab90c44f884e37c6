// SPDX-License-Identifier: Apache-2.0
#include "core/grid/scan_rays.h"

#include <algorithm>
#include <cmath>

namespace enfilade::grid {

ScanRays RaysOf(const sensor::LaserScan& scan, const Pose2& T_grid_robot, const ScanRayOptions& options) {
  const Pose2 T_grid_laser = T_grid_robot * scan.T_robot_laser;
  const double free_range = std::min({options.no_return_range, options.max_range, double{scan.range_max}});
  ScanRays rays;
  rays.origin = T_grid_laser.translation();
  rays.hits.reserve(scan.ranges.size());
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    const float range = scan.ranges[i];
    const sensor::BeamKind kind = sensor::ClassifyBeam(scan, range);
    if (kind == sensor::BeamKind::kUnknown || (kind == sensor::BeamKind::kNoReturn && free_range <= 0.0)) continue;
    const bool is_hit = kind == sensor::BeamKind::kHit && range <= options.max_range;
    const double length = kind == sensor::BeamKind::kNoReturn ? free_range : std::min(double{range}, options.max_range);
    const double angle = T_grid_laser.yaw + scan.angle(i);
    const Eigen::Vector2d end = rays.origin + length * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    (is_hit ? rays.hits : rays.free_ends).push_back(end);
  }
  return rays;
}

}  // namespace enfilade::grid
