// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "core/sensor/laser_scan.h"

namespace enfilade::sensor {

// For every beam i, the mean range (m) of the hits among beam i and its `half_width` neighbours on either side; nullopt
// if there is no hit among them. In a scan of a full turn the neighbours wrap around; in any other scan they stop at
// its ends. A negative half width counts as 0.
std::vector<std::optional<double>> MeanFilteredRanges(const LaserScan& scan, int half_width);

// The bounding box of the end points of the filtered beams, in m; empty (isEmpty()) without hits. It is aligned with
// the axes of the frame of `T_frame_robot`, by default the robot's. map_manager's third criterion for doors and its
// choice of the SLAM configuration use this box.
Eigen::AlignedBox2d FilteredBox(const LaserScan& scan, int half_width, const Pose2& T_frame_robot = {});

}  // namespace enfilade::sensor
