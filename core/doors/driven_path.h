// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <deque>

#include "core/base/binary.h"
#include "core/doors/visibility.h"
#include "core/sensor/laser_scan.h"

namespace enfilade::doors {

// The last metres of the robot's path, with what it saw from there. Places on it are given by the distance travelled
// since the first scan, m.
class DrivenPath {
 public:
  // Keeps `length` metres at least.
  explicit DrivenPath(double length) : length_(length) {}

  // A robot that stands still, or turns, keeps its last view only.
  void Add(const sensor::LaserScan& scan, const Pose2& T_odom_robot);

  bool empty() const { return points_.empty(); }
  // Of the latest scan. The path must not be empty, as for all below.
  const RangeView& view() const { return points_.back().view; }
  double travelled() const { return points_.back().travelled; }
  double oldest_travelled() const { return points_.front().travelled; }

  // The view at the first point that is not before `travelled`; the last one behind the path's end.
  const RangeView& ViewAt(double travelled) const { return points_[IndexAt(travelled)].view; }
  // Interpolated between points, in the odometry frame.
  Eigen::Vector2d PositionAt(double travelled) const;

  // The latest step, from the point before; both are the same if there is one point.
  struct Step {
    Eigen::Vector2d from = Eigen::Vector2d::Zero();  // odometry frame
    Eigen::Vector2d to = Eigen::Vector2d::Zero();
    double middle = 0.0;  // travelled, m

    double length() const { return (to - from).norm(); }
  };
  Step LastStep() const;

  void Write(BinaryWriter& writer) const;
  void Read(BinaryReader& reader);

 private:
  struct Point {
    double travelled = 0.0;  // m
    RangeView view;
  };

  std::size_t IndexAt(double travelled) const;

  double length_;
  std::deque<Point> points_;
};

}  // namespace enfilade::doors
