// SPDX-License-Identifier: Apache-2.0
#include "core/doors/driven_path.h"

#include <algorithm>
#include <utility>

namespace enfilade::doors {
namespace {

constexpr double kPathStep = 0.05;  // m between points that are kept

}  // namespace

void DrivenPath::Add(const sensor::LaserScan& scan, const Pose2& T_odom_robot) {
  const double step =
      points_.empty() ? 0.0 : (T_odom_robot.translation() - points_.back().view.T_odom_robot.translation()).norm();
  Point point{(points_.empty() ? 0.0 : points_.back().travelled) + step, RangeView::Of(scan, T_odom_robot)};
  const bool moved = points_.size() < 2 || point.travelled - points_[points_.size() - 2].travelled >= kPathStep;
  if (!moved) points_.pop_back();
  points_.push_back(std::move(point));
  while (points_.size() > 2 && points_.back().travelled - points_[1].travelled > length_) points_.pop_front();
}

std::size_t DrivenPath::IndexAt(double travelled) const {
  const auto found = std::lower_bound(points_.begin(), points_.end(), travelled,
                                      [](const Point& point, double value) { return point.travelled < value; });
  return found == points_.end() ? points_.size() - 1 : static_cast<std::size_t>(found - points_.begin());
}

Eigen::Vector2d DrivenPath::PositionAt(double travelled) const {
  const std::size_t i = IndexAt(travelled);
  Eigen::Vector2d at = points_[i].view.T_odom_robot.translation();
  if (i == 0) return at;
  const Eigen::Vector2d before = points_[i - 1].view.T_odom_robot.translation();
  const double length = points_[i].travelled - points_[i - 1].travelled;
  if (length <= 0.0) return at;
  return before + (at - before) * std::clamp((travelled - points_[i - 1].travelled) / length, 0.0, 1.0);
}

DrivenPath::Step DrivenPath::LastStep() const {
  const Point& now = points_.back();
  const Point& before = points_.size() < 2 ? now : points_[points_.size() - 2];
  return {.from = before.view.T_odom_robot.translation(),
          .to = now.view.T_odom_robot.translation(),
          .middle = (before.travelled + now.travelled) / 2.0};
}

void DrivenPath::Write(BinaryWriter& writer) const {
  writer.Put<std::uint64_t>(points_.size());
  for (const Point& point : points_) {
    writer.Put(point.travelled);
    PutView(writer, point.view);
  }
}

void DrivenPath::Read(BinaryReader& reader) {
  for (auto count = reader.Get<std::uint64_t>(); reader.ok() && count > 0; --count) {
    const auto travelled = reader.Get<double>();
    points_.push_back({travelled, GetView(reader)});
  }
}

}  // namespace enfilade::doors
