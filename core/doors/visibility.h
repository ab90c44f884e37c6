// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/base/binary.h"
#include "core/base/time.h"
#include "core/geometry/pose2.h"
#include "core/sensor/laser_scan.h"

namespace enfilade::doors {

// A scan thinned to about one beam a degree, with the place it was taken at.
struct RangeView {
  TimeNs time = 0;
  Pose2 T_odom_robot;
  Pose2 T_odom_laser;
  double angle_min = 0.0;        // rad
  double angle_increment = 0.0;  // rad, positive
  std::vector<float> ranges;     // m; infinite: no return, NaN: unknown

  // Counter-clockwise; the beams within a degree give their nearest hit.
  static RangeView Of(const sensor::LaserScan& scan, const Pose2& T_odom_robot);
};

// Of the ground that one view sees on its own side of the line through a and b, within `radius` of their middle, m^2:
// how much lies in the other's field of view, and how much of that is out of its sight.
struct HiddenGround {
  double seen = 0.0;
  double compared = 0.0;
  double hidden = 0.0;
};
HiddenGround CompareGround(const RangeView& seen, const RangeView& from, const Eigen::Vector2d& a,
                           const Eigen::Vector2d& b, double radius);

void PutView(BinaryWriter& writer, const RangeView& view);
RangeView GetView(BinaryReader& reader);

}  // namespace enfilade::doors
