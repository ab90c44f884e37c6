// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/simulator/route_driver.h"
#include "client/simulator/sensors/sensors.h"
#include "client/simulator/world/world.h"
#include "core/base/time.h"
#include "core/sensor/record.h"

namespace enfilade::simulator {

struct SimulationOptions {
  std::uint64_t seed = 1;
  TimeNs start_time = 1'700'000'000 * kNsPerSecond;
  MotionLimits motion;
  std::optional<int> laps;  // instead of the robot's
  // s: the robot is switched on at this time of its route, wherever it is then; what came before is not recorded.
  double start_after = 0.0;

  // Rates, Hz; 0 switches a sensor off. The rates are rounded so that a whole number of odometry steps lies between two
  // readings.
  double odometry_hz = 20.0;
  double scan_hz = 5.0;
  double cloud_hz = 0.0;
  double image_hz = 0.0;  // front and rear
  double depth_hz = 0.0;  // front
  // m: clouds, images and depth only within this distance of a door; 0: everywhere.
  double near_doors = 0.0;

  ScannerOptions scanner;
  CloudScannerOptions cloud;
  CameraOptions camera;

  // Odometry: each wheel's size is wrong by a constant factor with this standard deviation, and each distance d (m)
  // that a wheel rolls has a random error with the standard deviation slip * sqrt(d).
  double wheel_sigma = 0.006;
  double slip = 0.004;
  double track = 0.4;  // m, between the wheels

  // INVALID_ARGUMENT naming the option.
  absl::Status Validate() const;
};

struct SimulatedRecord {
  sensor::RecordPayload payload;
  std::string content;  // the bytes that an image or a cloud refers to
};

struct TruePose {
  TimeNs time = 0;
  Pose2 T_campus_robot;
  std::string level;
  std::string area;  // where the robot is; empty: in no area
};

// The robot's centre crosses the line between a door's jambs.
struct TruePassage {
  TimeNs time = 0;
  Pose2 T_campus_robot;
  std::string level;
  std::string door;
  std::string from;  // areas
  std::string to;
  double width = 0.0;      // m
  double incidence = 0.0;  // rad, between the direction of travel and the door's normal
};

struct GroundTruth {
  std::vector<TruePose> poses;  // at every scan
  std::vector<TruePassage> passages;
  double travelled = 0.0;  // m
};

// One robot's drive, record by record in order of time. The noise of each reading depends only on (seed, robot, sensor,
// index): the same campus, robot and options give the same records whatever else is simulated, and switching a sensor
// off does not change the others. Odometry starts at zero where the robot is switched on.
class RobotSimulation {
 public:
  // INVALID_ARGUMENT on bad options, NOT_FOUND: the campus has no such robot.
  static absl::StatusOr<RobotSimulation> Start(std::shared_ptr<const World> world, const std::string& robot,
                                               const SimulationOptions& options);

  // nullopt at the end of the route. FAILED_PRECONDITION: the route runs into a wall.
  absl::StatusOr<std::optional<SimulatedRecord>> Next();

  // Up to the record returned last.
  const GroundTruth& truth() const { return truth_; }
  const std::string& robot() const { return robot_; }
  // Where the robot is: how many levels above the one that it started on, below it if negative.
  int level() const;

 private:
  RobotSimulation(std::shared_ptr<const World> world, const Robot& robot, const SimulationOptions& options);

  absl::Status DriveUnrecorded();
  Noise NoiseOf(int sensor, std::int64_t index) const;
  bool Due(double hz) const;
  bool NearADoor() const;
  void MeasureStep(const RouteDriver::Step& step);
  void FindPassages(const Pose2& before);
  absl::Status Record();
  absl::Status RecordImages(const Viewpoint& view, TimeNs time);
  void RecordCloud(const Viewpoint& view, TimeNs time);
  TimeNs Now() const;

  std::shared_ptr<const World> world_;
  SimulationOptions options_;
  std::string robot_;
  std::string start_level_;
  std::uint64_t robot_seed_;
  RouteDriver driver_;
  double left_factor_;  // of the wheels' sizes
  double right_factor_;
  Pose2 T_odom_robot_;
  std::int64_t steps_ = 0;
  bool recorded_start_ = false;
  std::deque<SimulatedRecord> pending_;
  GroundTruth truth_;
};

struct Drive {
  std::vector<SimulatedRecord> records;
  GroundTruth truth;
};

// A whole drive.
absl::StatusOr<Drive> SimulateDrive(std::shared_ptr<const World> world, const std::string& robot,
                                    const SimulationOptions& options);

// Three rooms along a corridor, 19 m x 10.5 m (the shipped campus "rooms"), and a scanner of 270 degrees and 12 m.
SimulationOptions RoomsOptions();
absl::StatusOr<Drive> SimulateRooms(const SimulationOptions& options);

}  // namespace enfilade::simulator
