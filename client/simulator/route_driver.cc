// SPDX-License-Identifier: Apache-2.0
#include "client/simulator/route_driver.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace enfilade::simulator {
namespace {

constexpr double kArrived = 0.15;      // m, close enough to a point to head for the next
constexpr double kTurned = 0.02;       // rad
constexpr double kDoorApproach = 0.9;  // m in front of and behind a door in the route
constexpr double kObstacle = 0.5;      // m: faces that begin lower stop the robot

std::vector<RouteStep> StepsOf(const Robot& robot) {
  std::vector<RouteStep> steps;
  const auto go_home = [&] {
    steps.insert(steps.end(), robot.back.begin(), robot.back.end());
    steps.push_back(robot.route[0]);
  };
  for (int lap = 0; lap < robot.laps; ++lap) {
    if (lap > 0 && !robot.returns) go_home();
    steps.insert(steps.end(), robot.route.begin() + 1, robot.route.end());
    if (robot.returns) go_home();
  }
  return steps;
}

}  // namespace

RouteDriver::RouteDriver(std::shared_ptr<const World> world, const Robot& robot, const MotionLimits& limits,
                         double step_seconds)
    : world_(std::move(world)),
      robot_(robot),
      limits_(limits),
      dt_(step_seconds),
      level_(robot.level),
      steps_(StepsOf(robot)) {
  if (robot_.speed) limits_.speed = *robot_.speed;
  const Eigen::Vector2d start = robot_.route[0].point;
  pose_ = {start.x(), start.y(), 0.0};
  // It starts heading for its first point or door.
  for (std::size_t i = 1; i < robot_.route.size(); ++i) {
    const RouteStep& step = robot_.route[i];
    if (step.kind == RouteStep::Kind::kTurnTo) {
      pose_.yaw = step.value;
    } else if (step.kind == RouteStep::Kind::kPoint || step.kind == RouteStep::Kind::kDoor) {
      const Eigen::Vector2d to =
          (step.kind == RouteStep::Kind::kPoint ? step.point : world_->campus().FindDoor(step.name)->middle()) - start;
      pose_.yaw = std::atan2(to.y(), to.x());
    } else {
      continue;
    }
    break;
  }
}

void RouteDriver::Expand() {
  if (next_step_ == steps_.size()) return;
  const RouteStep& step = steps_[next_step_];
  if (step.kind == RouteStep::Kind::kDoor) {
    const Door& door = *world_->campus().FindDoor(step.name);
    const Eigen::Vector2d on = (door.b - door.a).normalized();
    Eigen::Vector2d through(-on.y(), on.x());
    if (through.dot(pose_.translation() - door.middle()) > 0.0) through = -through;
    for (const double way : {-kDoorApproach, kDoorApproach}) {
      RouteStep point;
      point.point = door.middle() + way * through;
      goals_.push_back({point, 0.0});
    }
  } else {
    goals_.push_back({step, step.value});
  }
  ++next_step_;
}

absl::StatusOr<RouteDriver::Step> RouteDriver::Advance(Step step) {
  const Eigen::Vector2d before = pose_.translation();
  pose_ = pose_ * ArcStep(step.forward, step.turn);
  const Eigen::Vector2d way = pose_.translation() - before;
  bool blocked = false;
  if (way.norm() > 0.0) {
    world_->level(level_).Traverse(before, way, 1.0, gate_, [&](double, const Face& face) {
      blocked = face.bottom < kObstacle;
      return !blocked;
    });
  }
  if (blocked) {
    return FailedPrecondition("robot {}: the route runs into a wall at ({:.2f}, {:.2f}) m", robot_.id, pose_.x,
                              pose_.y);
  }
  return step;
}

absl::StatusOr<std::optional<RouteDriver::Step>> RouteDriver::Ride(Goal& goal) {
  const Area* here = world_->campus().AreaAt(level_, pose_.translation());
  if (gate_ < 0 && (!here || here->id != goal.step.name)) {
    return FailedPrecondition("robot {}: is to ride lift {} but is not in it", robot_.id, goal.step.name);
  }
  gate_ = world_->GateOf(goal.step.name);
  goal.left -= dt_;
  if (goal.left <= goal.step.value / 2.0) level_ = goal.step.level;
  if (goal.left <= 0.0) {
    gate_ = -1;
    goals_.pop_front();
  }
  return Step{};
}

absl::StatusOr<std::optional<RouteDriver::Step>> RouteDriver::Next() {
  while (true) {
    if (goals_.empty()) Expand();
    if (goals_.empty()) return std::nullopt;
    Goal& goal = goals_.front();
    switch (goal.step.kind) {
      case RouteStep::Kind::kLift:
        return Ride(goal);
      case RouteStep::Kind::kWait:
        goal.left -= dt_;
        if (goal.left <= 0.0) goals_.pop_front();
        return Step{};
      case RouteStep::Kind::kTurnTo: {
        const double off = WrapAngle(goal.step.value - pose_.yaw);
        if (std::abs(off) < kTurned) {
          goals_.pop_front();
          continue;
        }
        return Advance({0.0, std::clamp(off, -limits_.turn_rate * dt_, limits_.turn_rate * dt_)});
      }
      default:
        break;
    }
    const Eigen::Vector2d way = goal.step.point - pose_.translation();
    if (way.norm() <= kArrived) {
      goals_.pop_front();
      continue;
    }
    const double off_course = WrapAngle(std::atan2(way.y(), way.x()) - pose_.yaw);
    const double turn = std::clamp(2.0 * off_course, -limits_.turn_rate, limits_.turn_rate) * dt_;
    // The robot slows down off course, and turns on the spot far off course.
    const double forward = limits_.speed * std::max(0.0, 1.0 - std::abs(off_course) / 0.8) * dt_;
    return Advance({forward, turn});
  }
}

}  // namespace enfilade::simulator
