// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/base/binary.h"
#include "core/base/time.h"
#include "core/geometry/pose2.h"
#include "core/sensor/laser_scan.h"

namespace enfilade::doors {

// A scan thinned to about one beam per degree, with the pose that it was taken from.
struct RangeView {
  TimeNs time = 0;
  Pose2 T_odom_robot;
  Pose2 T_odom_laser;
  double angle_min = 0.0;        // rad
  double angle_increment = 0.0;  // rad, positive
  std::vector<float> ranges;     // m; infinite: no return, NaN: unknown

  // Beams counter-clockwise; of those within a degree the nearest hit.
  static RangeView Of(const sensor::LaserScan& scan, const Pose2& T_odom_robot);
};

// Ground that one view sees on its own side of a line, m^2: how much of it lies in another view's field of view, and
// how much of that is hidden from it.
struct HiddenGround {
  double seen = 0.0;
  double compared = 0.0;
  double hidden = 0.0;
};
// `seen` and `from` are the two views, a and b define the line; only ground within `radius` of their middle counts.
HiddenGround CompareGround(const RangeView& seen, const RangeView& from, const Eigen::Vector2d& a,
                           const Eigen::Vector2d& b, double radius);

void PutView(BinaryWriter& writer, const RangeView& view);
RangeView GetView(BinaryReader& reader);

}  // namespace enfilade::doors
