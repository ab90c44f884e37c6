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

// Up to `most` to both sides, the middle first.
std::vector<double> Errors(double most, int steps) {
  std::vector<double> errors = {0.0};
  for (int step = 1; step <= steps; ++step) {
    for (const double side : {-1.0, 1.0}) errors.push_back(side * most * step / steps);
  }
  return errors;
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

Continuity::Contradiction Continuity::Compare(const View& a, const View& b) const {
  const Pose2 T_b_a = Between(b.T_odom_robot, a.T_odom_robot);
  Contradiction least;
  for (const double x : Errors(options_.position_error, 2)) {
    for (const double y : Errors(options_.position_error, 2)) {
      for (const double yaw : Errors(options_.yaw_error, 6)) {
        const Pose2 moved = T_b_a * Pose2{x, y, yaw};
        const Contradiction found{FreeShare(a, b, moved), FreeShare(b, a, Inverse(moved))};
        if (found.sum() < least.sum()) least = found;
        if (least.sum() <= options_.alike) return least;
      }
    }
  }
  return least;
}

bool Continuity::IsLarge(const Contradiction& found) const {
  return found.sum() > options_.contradicted ||
         (found.sum() > options_.exchanged && std::min(found.of_a, found.of_b) > options_.exchanged_each);
}

bool Continuity::IsSuspect(const View& view) const {
  if (moved_ < options_.odometry_works) return false;
  const bool follows = suspect_ > 0 && agreeing_ > 0;
  const double far = follows ? options_.comparable_after : 1.0;
  const Pose2 since = Between(known_->T_odom_robot, view.T_odom_robot);
  if (since.translation().norm() > far * options_.comparable) return false;
  if (std::abs(since.yaw) > far * options_.comparable_yaw) return false;
  const Contradiction found = Compare(view, *known_);
  return follows ? found.sum() > options_.alike : IsLarge(found);
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
  agreeing_ = last_ && Compare(view, *last_).sum() > options_.contradicted ? 0 : agreeing_ + 1;
  last_ = view;
  if (!known_) {
    if (settled()) known_ = std::move(view);
    return std::nullopt;
  }
  if (!IsSuspect(view)) {
    suspect_ = 0;
    known_ = std::move(view);
    return std::nullopt;
  }
  if (++suspect_ < options_.scans) return std::nullopt;
  return Break("the scans contradict those before: the robot was carried away, or its odometry jumped");
}

}  // namespace enfilade::robot
