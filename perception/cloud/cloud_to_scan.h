// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <numbers>

#include "absl/status/statusor.h"
#include "core/sensor/laser_scan.h"
#include "perception/cloud/cloud.h"

namespace enfilade::perception {

// Defaults: the scan that the original's door detector saw (pointcloud_to_laserscan in base_link).
struct CloudToScanOptions {
  double min_height = 0.5;  // m, of the points that count, in the frame of the cloud
  double max_height = 1.7;
  double angle_min = -std::numbers::pi;  // rad; the last beam lies at or before angle_max
  double angle_max = std::numbers::pi;
  double angle_increment = 0.0087;  // rad, 0.5 deg
  double range_min = 0.2;           // m; nearer and farther points are left out
  double range_max = 100.0;
  bool use_inf = true;  // a beam without a point reads +infinity, otherwise range_max + 1; "no return" both ways
};

absl::Status Validate(const CloudToScanOptions& options);

// The nearest point, in the plane, of each sector of one increment: beam i takes the points from angle_min + i *
// increment up to the next beam, as pointcloud_to_laserscan does. The scan is in the cloud's frame (T_robot_laser is
// identity for a cloud in the robot's frame). Points that are not finite are left out. INVALID_ARGUMENT: options.
absl::StatusOr<sensor::LaserScan> CloudToScan(const Cloud& cloud, TimeNs time, const CloudToScanOptions& options = {});

}  // namespace enfilade::perception
