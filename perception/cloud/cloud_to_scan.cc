// SPDX-License-Identifier: Apache-2.0
#include "perception/cloud/cloud_to_scan.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace enfilade::perception {

absl::Status Validate(const CloudToScanOptions& options) {
  if (!(options.min_height <= options.max_height)) {
    return InvalidArgument("heights {} to {} m: expected the lower first", options.min_height, options.max_height);
  }
  if (!(options.angle_increment > 0.0) || !(options.angle_max > options.angle_min) ||
      !(options.angle_max - options.angle_min <= 2.0 * std::numbers::pi + 1e-6)) {
    return InvalidArgument("angles {} to {} rad in steps of {}: expected at most one turn, upwards", options.angle_min,
                           options.angle_max, options.angle_increment);
  }
  if ((options.angle_max - options.angle_min) / options.angle_increment > static_cast<double>(sensor::kMaxBeams)) {
    return InvalidArgument("angle_increment {} rad: more than {} beams", options.angle_increment, sensor::kMaxBeams);
  }
  if (!(options.range_min >= 0.0) || !(options.range_max > options.range_min) || !std::isfinite(options.range_max)) {
    return InvalidArgument("ranges {} to {} m: expected 0 <= range_min < range_max", options.range_min,
                           options.range_max);
  }
  return absl::OkStatus();
}

absl::StatusOr<sensor::LaserScan> CloudToScan(const Cloud& cloud, TimeNs time, const CloudToScanOptions& options) {
  ENFILADE_RETURN_IF_ERROR(Validate(options));
  sensor::LaserScan scan;
  scan.time = time;
  scan.angle_min = options.angle_min;
  scan.angle_increment = options.angle_increment;
  scan.range_min = static_cast<float>(options.range_min);
  scan.range_max = static_cast<float>(options.range_max);
  const auto beams =
      static_cast<std::size_t>(std::ceil((options.angle_max - options.angle_min) / options.angle_increment));
  const float nothing =
      options.use_inf ? std::numeric_limits<float>::infinity() : static_cast<float>(options.range_max + 1.0);
  scan.ranges.assign(std::max<std::size_t>(beams, 1), nothing);
  for (const Eigen::Vector3f& point : cloud.points) {
    if (!point.allFinite() || point.z() < options.min_height || point.z() > options.max_height) continue;
    const double range = std::hypot(static_cast<double>(point.x()), static_cast<double>(point.y()));
    if (range < options.range_min || range > options.range_max) continue;
    const double angle = std::atan2(static_cast<double>(point.y()), static_cast<double>(point.x()));
    if (angle < options.angle_min || angle > options.angle_max) continue;
    const auto beam = std::min(static_cast<std::size_t>((angle - options.angle_min) / options.angle_increment),
                               scan.ranges.size() - 1);
    scan.ranges[beam] = std::min(scan.ranges[beam], static_cast<float>(range));
  }
  return scan;
}

}  // namespace enfilade::perception
