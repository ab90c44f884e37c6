// SPDX-License-Identifier: Apache-2.0
#include "core/sensor/laser_scan.h"

#include <cmath>

#include "core/base/error.h"

namespace enfilade::sensor {

BeamCounts CountBeams(const LaserScan& scan) {
  BeamCounts counts;
  for (const float range : scan.ranges) {
    switch (ClassifyBeam(scan, range)) {
      case BeamKind::kHit:
        ++counts.hits;
        break;
      case BeamKind::kNoReturn:
        ++counts.no_returns;
        break;
      case BeamKind::kUnknown:
        ++counts.unknown;
        break;
    }
  }
  return counts;
}

std::vector<Eigen::Vector2d> HitPoints(const LaserScan& scan, double max_range) {
  std::vector<Eigen::Vector2d> points;
  points.reserve(scan.ranges.size());
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    const float range = scan.ranges[i];
    if (ClassifyBeam(scan, range) != BeamKind::kHit || range >= max_range) continue;
    const double angle = scan.angle(i);
    points.push_back(scan.T_robot_laser * Eigen::Vector2d(static_cast<double>(range) * std::cos(angle),
                                                          static_cast<double>(range) * std::sin(angle)));
  }
  return points;
}

absl::Status Validate(const LaserScan& scan) {
  if (scan.ranges.empty()) return InvalidArgument("laser_scan.ranges is empty: a scan needs at least one beam");
  if (scan.ranges.size() > kMaxBeams) {
    return InvalidArgument("laser_scan.ranges has {} beams, more than the limit of {}", scan.ranges.size(), kMaxBeams);
  }
  if (!std::isfinite(scan.angle_min) || std::abs(scan.angle_min) > 4.0 * M_PI) {
    return InvalidArgument("laser_scan.angle_min is {}: expected radians within +-4 pi", scan.angle_min);
  }
  if (!std::isfinite(scan.angle_increment) || std::abs(scan.angle_increment) > 2.0 * M_PI ||
      (scan.angle_increment == 0.0 && scan.ranges.size() > 1)) {
    return InvalidArgument("laser_scan.angle_increment is {}: expected non-zero radians within +-2 pi",
                           scan.angle_increment);
  }
  if (!std::isfinite(scan.time_increment)) {
    return InvalidArgument("laser_scan.time_increment is {}: expected finite seconds", scan.time_increment);
  }
  if (!(scan.range_min >= 0.0F) || !std::isfinite(scan.range_max) || !(scan.range_max > scan.range_min)) {
    return InvalidArgument("laser_scan range limits are [{}, {}]: expected 0 <= range_min < range_max < infinity",
                           scan.range_min, scan.range_max);
  }
  const Pose2& mount = scan.T_robot_laser;
  if (!IsFinite(mount) || std::hypot(mount.x, mount.y) > kMaxMountDistance) {
    return InvalidArgument("laser_scan.mount ({}, {}, {}): expected finite, and at most {} m from the robot's origin",
                           mount.x, mount.y, mount.yaw, kMaxMountDistance);
  }
  return absl::OkStatus();
}

}  // namespace enfilade::sensor
