// SPDX-License-Identifier: Apache-2.0
#include "core/doors/visibility.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/geometry/pose2.h"
#include "core/geometry/pose_codec.h"

namespace enfilade::doors {
namespace {

constexpr double kStep = 0.2;  // m between places along a beam

}  // namespace

RangeView RangeView::Of(const sensor::LaserScan& scan, const Pose2& T_odom_robot) {
  RangeView view;
  view.time = scan.time;
  view.T_odom_robot = T_odom_robot;
  view.T_odom_laser = T_odom_robot * scan.T_robot_laser;
  const double increment = std::abs(scan.angle_increment);
  const std::size_t beams = scan.ranges.size();
  const auto together = static_cast<std::size_t>(std::clamp(std::round(kDegree / std::max(increment, 1e-9)), 1.0, 1e5));
  const bool forward = scan.angle_increment >= 0.0;
  view.angle_increment = increment * static_cast<double>(together);
  view.angle_min =
      (forward ? scan.angle(0) : scan.angle(beams - 1)) + increment * (static_cast<double>(together) - 1.0) / 2.0;
  for (std::size_t begin = 0; begin < beams; begin += together) {
    float range = std::numeric_limits<float>::quiet_NaN();
    for (std::size_t i = begin; i < std::min(beams, begin + together); ++i) {
      const float one = scan.ranges[forward ? i : beams - 1 - i];
      const sensor::BeamKind kind = sensor::ClassifyBeam(scan, one);
      if (kind == sensor::BeamKind::kUnknown) continue;
      const float seen = kind == sensor::BeamKind::kHit ? one : std::numeric_limits<float>::infinity();
      if (std::isnan(range) || seen < range) range = seen;
    }
    view.ranges.push_back(range);
  }
  return view;
}

HiddenGround CompareGround(const RangeView& seen, const RangeView& from, const Eigen::Vector2d& a,
                           const Eigen::Vector2d& b, double radius) {
  HiddenGround ground;
  if (!(from.angle_increment > 0.0)) return ground;
  const Eigen::Vector2d middle = (a + b) / 2.0;
  const Eigen::Vector2d normal(a.y() - b.y(), b.x() - a.x());
  const bool side = normal.dot(seen.T_odom_laser.translation() - middle) > 0.0;
  for (std::size_t i = 0; i < seen.ranges.size(); ++i) {
    if (std::isnan(seen.ranges[i])) continue;
    const double angle = seen.angle_min + seen.angle_increment * static_cast<double>(i);
    const Eigen::Vector2d ray(std::cos(angle), std::sin(angle));
    const double end = std::min(static_cast<double>(seen.ranges[i]) - kStep / 2.0, 2.0 * radius);
    for (double r = kStep; r < end; r += kStep) {
      const Eigen::Vector2d point = seen.T_odom_laser * Eigen::Vector2d(r * ray);
      if ((point - middle).norm() > radius || (normal.dot(point - middle) > 0.0) != side) continue;
      const double area = r * kStep * seen.angle_increment;
      ground.seen += area;
      const Eigen::Vector2d to = point - from.T_odom_laser.translation();
      double bearing = WrapAngle(std::atan2(to.y(), to.x()) - from.T_odom_laser.yaw) - from.angle_min;
      bearing -= 2.0 * M_PI * std::floor((bearing + from.angle_increment / 2.0) / (2.0 * M_PI));
      const auto beam = static_cast<std::size_t>(std::max(0.0, std::round(bearing / from.angle_increment)));
      if (beam >= from.ranges.size() || std::isnan(from.ranges[beam])) continue;
      ground.compared += area;
      if (static_cast<double>(from.ranges[beam]) < to.norm()) ground.hidden += area;
    }
  }
  return ground;
}

void PutView(BinaryWriter& writer, const RangeView& view) {
  writer.Put(view.time);
  PutPose(writer, view.T_odom_robot);
  PutPose(writer, view.T_odom_laser);
  writer.Put(view.angle_min);
  writer.Put(view.angle_increment);
  writer.PutVector(view.ranges);
}

RangeView GetView(BinaryReader& reader) {
  RangeView view;
  view.time = reader.Get<TimeNs>();
  view.T_odom_robot = GetPose(reader);
  view.T_odom_laser = GetPose(reader);
  view.angle_min = reader.Get<double>();
  view.angle_increment = reader.Get<double>();
  view.ranges = reader.GetVector<float>();
  return view;
}

}  // namespace enfilade::doors
