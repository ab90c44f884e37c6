// SPDX-License-Identifier: Apache-2.0
#include "client/robot/agent/continuity.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "core/slam/submaps/robot_rays.h"
#include "fmt/format.h"

namespace enfilade::robot {
namespace {

constexpr double kMaxRange = 30.0;  // m
constexpr int kDirections = 360;
constexpr int kBeside = 2;  // directions to either side, so that edges contradict nothing

int DirectionOf(const Eigen::Vector2d& point) {
  const double turn = (std::atan2(point.y(), point.x()) + M_PI) / (2.0 * M_PI);
  return std::min(static_cast<int>(turn * kDirections), kDirections - 1);
}

}  // namespace

Continuity::View Continuity::ViewOf(const sensor::LaserScan& scan, const Pose2& T_odom_robot) const {
  View view{slam::RobotRays(scan, {kMaxRange, 0.0}).hits, std::vector<float>(kDirections, -1.0F), T_odom_robot};
  for (const Eigen::Vector2d& hit : view.hits) {
    float& reach = view.reach[static_cast<std::size_t>(DirectionOf(hit))];
    const auto range = static_cast<float>(hit.norm());
    reach = reach < 0.0F ? range : std::min(reach, range);
  }
  return view;
}

double Continuity::FreeShare(const View& a, const View& b, const Pose2& T_b_a) const {
  int seen = 0;
  int free = 0;
  for (const Eigen::Vector2d& hit : a.hits) {
    const Eigen::Vector2d in_b = T_b_a * hit;
    const int direction = DirectionOf(in_b);
    float reach = b.reach[static_cast<std::size_t>(direction)];
    if (reach < 0.0F) continue;
    for (int beside = -kBeside; beside <= kBeside; ++beside) {
      const float other = b.reach[static_cast<std::size_t>((direction + beside + kDirections) % kDirections)];
      if (other >= 0.0F) reach = std::min(reach, other);
    }
    ++seen;
    const double range = in_b.norm();
    if (range < reach - options_.tolerance - options_.range_tolerance * range) ++free;
  }
  return seen > 0 ? static_cast<double>(free) / seen : 0.0;
}

bool Continuity::Contradict(const View& a, const View& b) const {
  constexpr int kSteps = 6;
  const Pose2 T_b_a = Between(b.T_odom_robot, a.T_odom_robot);
  for (int step = -kSteps; step <= kSteps; ++step) {
    const Pose2 turned = T_b_a * Pose2{0.0, 0.0, options_.yaw_error * step / kSteps};
    if (FreeShare(a, b, turned) + FreeShare(b, a, Inverse(turned)) <= options_.contradicted) return false;
  }
  return true;
}

std::optional<std::string> Continuity::Break(std::string reason) {
  known_.reset();
  last_.reset();
  suspect_ = agreeing_ = 0;
  blind_ = 0.0;
  return reason;
}

std::optional<std::string> Continuity::Add(const sensor::LaserScan& scan, const Pose2& T_odom_robot) {
  const double way = T_odom_last_ ? Between(*T_odom_last_, T_odom_robot).translation().norm() : 0.0;
  const double seconds = std::max(ToSeconds(scan.time - last_time_), 0.0);
  T_odom_last_ = T_odom_robot;
  last_time_ = scan.time;
  if (known_ && way > options_.jump + options_.jump_speed * seconds) {
    return Break(fmt::format("odometry jumps by {:.1f} m in {:.1f} s", way, seconds));
  }
  blind_ += way;
  moved_ += way;
  View view = ViewOf(scan, T_odom_robot);
  if (static_cast<int>(view.hits.size()) < options_.min_hits) {
    agreeing_ = 0;
    if (!known_ || blind_ < options_.blind_distance) return std::nullopt;
    return Break(fmt::format("the robot has seen no walls for {:.1f} m", options_.blind_distance));
  }
  blind_ = 0.0;
  agreeing_ = last_ && Contradict(view, *last_) ? 0 : agreeing_ + 1;
  last_ = view;
  if (!known_) {
    if (settled()) known_ = std::move(view);
    return std::nullopt;
  }
  const Pose2 since = Between(known_->T_odom_robot, T_odom_robot);
  const bool comparable = moved_ >= options_.odometry_works && since.translation().norm() <= options_.comparable &&
                          std::abs(since.yaw) <= options_.comparable_yaw;
  if (!comparable || !Contradict(view, *known_)) {
    suspect_ = 0;
    known_ = std::move(view);
    return std::nullopt;
  }
  if (++suspect_ < options_.scans) return std::nullopt;
  return Break("the scans contradict those before: the robot was carried away, or its odometry jumped");
}

}  // namespace enfilade::robot
