// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "core/sensor/laser_scan.h"

namespace enfilade::sensor {

// The mean of the hits among beam i and its `half_width` neighbours on either side, for every beam, in m; nullopt where
// there is no hit among them. Around a scan of a full turn the neighbours go on at its other end; elsewhere they end
// with the scan. A negative half width counts as 0.
std::vector<std::optional<double>> MeanFilteredRanges(const LaserScan& scan, int half_width);

// The box around the ends of the filtered beams, in the robot's frame, m; empty (isEmpty()) without hits. With a
// pose, the box is in that frame: its sides lie along the frame's axes. The third criterion of the original's door
// detector and its choice of the SLAM configuration look at it.
Eigen::AlignedBox2d FilteredBox(const LaserScan& scan, int half_width, const Pose2& T_frame_robot = {});

}  // namespace enfilade::sensor
