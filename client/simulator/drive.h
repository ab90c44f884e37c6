#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "client/simulator/floor_plan.h"
#include "client/sources/log_reader.h"
#include "core/base/time.h"
#include "core/geometry/pose2.h"

namespace enfilade::simulator {

struct DriveOptions {
  std::uint64_t seed = 1;
  int laps = 2;  // round the route; from the second on the robot sees what it has seen before
  TimeNs start_time = 1'700'000'000 * kNsPerSecond;

  double speed = 0.6;      // m/s
  double turn_rate = 0.9;  // rad/s at most
  double odometry_hz = 20.0;
  double scan_hz = 5.0;  // divides odometry_hz

  int beams = 361;
  double field_of_view = 1.5 * M_PI;  // rad
  double range_max = 12.0;            // m
  double range_sigma = 0.01;          // m
  double dropout = 0.002;             // share of beams that read NaN
  Pose2 T_robot_laser{0.2, 0.0, 0.0};

  // Wheels, as odometry sees them: each one's size is off by a constant factor drawn from this, and every way driven
  // is off at random by slip * sqrt(way in m) metres.
  double wheel_sigma = 0.006;
  double slip = 0.004;
  double track = 0.4;  // m, between the wheels

  // INVALID_ARGUMENT naming the option.
  absl::Status Validate() const;
};

struct TruePose {
  TimeNs time = 0;
  Pose2 T_plan_robot;
};

struct Drive {
  std::vector<sources::LogEntry> entries;  // odometry and scans, in the order of time
  std::vector<TruePose> truth;             // at every scan
};

// Drives the plan's route. Odometry starts at zero. The same plan and options give the same drive. INVALID_ARGUMENT on
// bad options; FAILED_PRECONDITION where the route runs into a wall.
absl::StatusOr<Drive> SimulateDrive(const FloorPlan& plan, const DriveOptions& options);

}  // namespace enfilade::simulator
