// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/simulator/world/world.h"
#include "core/geometry/pose2.h"

namespace enfilade::simulator {

struct MotionLimits {
  double speed = 0.6;      // m/s
  double turn_rate = 0.9;  // rad/s
};

// One step of a robot on two wheels, along an arc.
inline Pose2 ArcStep(double forward, double turn) {
  return {forward * std::cos(turn / 2.0), forward * std::sin(turn / 2.0), turn};
}

// Drives a robot along its route without noise: towards one point after the other, slower when off course, turning on
// the spot when far off course.
class RouteDriver {
 public:
  RouteDriver(std::shared_ptr<const World> world, const Robot& robot, const MotionLimits& limits, double step_seconds);

  struct Step {
    double forward = 0.0;  // m
    double turn = 0.0;     // rad
  };
  // The next step; nullopt at the route's end. FAILED_PRECONDITION: it runs into a wall, or is to ride a lift
  // in which it is not.
  absl::StatusOr<std::optional<Step>> Next();

  const Pose2& T_campus_robot() const { return pose_; }
  const std::string& level() const { return level_; }
  int gate() const { return gate_; }  // the lift in which it rides, or -1

 private:
  struct Goal {
    RouteStep step;
    double left = 0.0;  // s, of waiting
  };

  void Expand();  // the next step into goals
  absl::StatusOr<Step> Advance(Step step);
  absl::StatusOr<std::optional<Step>> Ride(Goal& goal);

  std::shared_ptr<const World> world_;
  Robot robot_;
  MotionLimits limits_;
  double dt_;
  Pose2 pose_;
  std::string level_;
  int gate_ = -1;
  std::vector<RouteStep> steps_;  // of all laps, after the start
  std::size_t next_step_ = 0;
  std::deque<Goal> goals_;
};

}  // namespace enfilade::simulator
