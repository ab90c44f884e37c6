// SPDX-License-Identifier: Apache-2.0
#include "client/robot/agent/lift_exit.h"

#include <algorithm>
#include <cmath>

namespace enfilade::robot {
namespace {

constexpr double kDeepest = 5.0;      // m: no cabin is deeper
constexpr double kStep = 0.1;         // m between the places of the way that are kept
constexpr double kMissed = 3.0;       // m behind the door: the detector reports doors 1 to 2 m behind them
constexpr double kSameDoor = 1.5;     // m
constexpr double kDoorsMargin = 0.3;  // m beside the posts: odometry and the detector err
constexpr double kOutOfCabin = 1.5;   // m from where the robot stood, if the door is not known

double Distance(const Pose2& a, const Pose2& b) { return (a.translation() - b.translation()).norm(); }

}  // namespace

void LiftExit::Begin(const Pose2& T_odom_robot) {
  start_ = T_odom_robot;
  entry_.reset();
  way_.clear();
}

void LiftExit::EnteredBy(const doors::DoorEvent& passage) {
  if (start_ && Distance(passage.T_odom_door, *start_) < kDeepest) entry_ = passage;
}

void LiftExit::Add(TimeNs time, const Pose2& T_odom_robot) {
  if (!start_ || (!way_.empty() && Distance(way_.back().T_odom_robot, T_odom_robot) < kStep)) return;
  way_.push_back({time, T_odom_robot});
}

std::optional<doors::DoorEvent> LiftExit::FindMissed() const {
  if (!start_ || way_.empty()) return std::nullopt;
  const Pose2& now = way_.back().T_odom_robot;
  if (const auto out = FindThroughEntry(); out && Distance(out->T_odom_door, now) >= kMissed) return out;
  if (Distance(*start_, now) < kDeepest) return std::nullopt;
  const auto outside = std::find_if(way_.begin(), way_.end(), [this](const Place& place) {
    return Distance(*start_, place.T_odom_robot) >= kOutOfCabin;
  });
  return EventAt(*outside, outside->T_odom_robot, 0.0);
}

std::optional<doors::DoorEvent> LiftExit::FindBefore(const Pose2& T_odom_door) const {
  if (!start_) return std::nullopt;
  const auto out = FindThroughEntry();
  return out && Distance(out->T_odom_door, T_odom_door) > kSameDoor ? out : std::nullopt;
}

std::optional<doors::DoorEvent> LiftExit::FindThroughEntry() const {
  if (!entry_) return std::nullopt;
  const Pose2 T_door_odom = Inverse(entry_->T_odom_door);  // the cabin is ahead of the door
  for (std::size_t i = 1; i < way_.size(); ++i) {
    const Eigen::Vector2d inside = T_door_odom * way_[i - 1].T_odom_robot.translation();
    const Eigen::Vector2d outside = T_door_odom * way_[i].T_odom_robot.translation();
    if (inside.x() < 0.0 || outside.x() >= 0.0) continue;
    if (std::abs(outside.y()) > entry_->width / 2.0 + kDoorsMargin) continue;
    const Pose2& in = entry_->T_odom_door;
    return EventAt(way_[i], {in.x, in.y, WrapAngle(in.yaw + M_PI)}, entry_->width);
  }
  return std::nullopt;
}

doors::DoorEvent LiftExit::EventAt(const Place& place, const Pose2& T_odom_door, double width) const {
  doors::DoorEvent event;
  event.kind = doors::DoorEvent::Kind::kPassage;
  event.time = way_.back().time;
  event.T_odom_robot = way_.back().T_odom_robot;
  event.T_odom_door = T_odom_door;
  event.door_time = place.time;
  event.width = width;
  event.reason = "out of the lift, though no door was found";
  return event;
}

}  // namespace enfilade::robot
