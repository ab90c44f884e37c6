// SPDX-License-Identifier: Apache-2.0
#include "client/simulator/simulation.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "client/simulator/campus/shipped_campuses.h"
#include "core/base/error.h"
#include "core/base/sha256.h"
#include "core/base/status_macros.h"

namespace enfilade::simulator {
namespace {

enum Sensor : int { kWheelSizes, kWheels, kScanner, kCloudScanner, kFrontCamera, kRearCamera };

constexpr double kBesideDoor = 0.4;  // m from a door: where the areas on its two sides are looked up

sensor::BlobRef RefOf(const std::string& content) {
  return {Sha256(content), static_cast<std::int64_t>(content.size())};
}

}  // namespace

absl::Status SimulationOptions::Validate() const {
  const auto positive = [](const char* name, double value) {
    if (value > 0.0 && std::isfinite(value)) return absl::OkStatus();
    return InvalidArgument("{} is {}: expected a number above 0", name, value);
  };
  if (laps && (*laps < 1 || *laps > 1000)) return InvalidArgument("laps is {}: expected 1 to 1000", *laps);
  ENFILADE_RETURN_IF_ERROR(positive("speed", motion.speed));
  ENFILADE_RETURN_IF_ERROR(positive("turn_rate", motion.turn_rate));
  ENFILADE_RETURN_IF_ERROR(positive("odometry_hz", odometry_hz));
  ENFILADE_RETURN_IF_ERROR(positive("track", track));
  for (const auto& [name, hz] :
       {std::pair{"scan_hz", scan_hz}, {"cloud_hz", cloud_hz}, {"image_hz", image_hz}, {"depth_hz", depth_hz}}) {
    if (!(hz >= 0.0 && hz <= odometry_hz)) {
      return InvalidArgument("{} is {}: expected 0 to odometry_hz ({})", name, hz, odometry_hz);
    }
  }
  if (!(start_after >= 0.0 && start_after <= 1e6)) {
    return InvalidArgument("start_after is {} s: expected 0 to 1000000", start_after);
  }
  if (!(wheel_sigma >= 0.0 && slip >= 0.0 && near_doors >= 0.0)) {
    return InvalidArgument("wheel_sigma, slip and near_doors must not be negative");
  }
  if (motion.speed / odometry_hz > 0.15) {
    return InvalidArgument("speed is {} m/s: too fast for an odometry rate of {} Hz", motion.speed, odometry_hz);
  }
  ENFILADE_RETURN_IF_ERROR(scanner.Validate());
  return camera.Validate();
}

absl::StatusOr<RobotSimulation> RobotSimulation::Start(std::shared_ptr<const World> world, const std::string& robot,
                                                       const SimulationOptions& options) {
  ENFILADE_RETURN_IF_ERROR(options.Validate());
  const Robot* found = world->campus().FindRobot(robot);
  if (!found) return NotFound("campus {} has no robot \"{}\"", world->campus().name, robot);
  Robot plan = *found;
  if (options.laps) plan.laps = *options.laps;
  RobotSimulation simulation(std::move(world), plan, options);
  ENFILADE_RETURN_IF_ERROR(simulation.DriveUnrecorded());
  return simulation;
}

absl::Status RobotSimulation::DriveUnrecorded() {
  const std::int64_t first = std::llround(options_.start_after * options_.odometry_hz);
  while (steps_ < first) {
    ENFILADE_ASSIGN_OR_RETURN(const std::optional<RouteDriver::Step> step, driver_.Next());
    if (!step) break;
    ++steps_;
  }
  start_level_ = driver_.level();
  return absl::OkStatus();
}

RobotSimulation::RobotSimulation(std::shared_ptr<const World> world, const Robot& robot,
                                 const SimulationOptions& options)
    : world_(std::move(world)),
      options_(options),
      robot_(robot.id),
      start_level_(robot.level),
      robot_seed_(Mix(options.seed, SeedOf(robot.id))),
      driver_(world_, robot, options.motion, 1.0 / options.odometry_hz) {
  Noise noise = NoiseOf(kWheelSizes, 0);
  left_factor_ = 1.0 + options_.wheel_sigma * noise.Normal();
  right_factor_ = 1.0 + options_.wheel_sigma * noise.Normal();
}

int RobotSimulation::level() const {
  const std::map<std::string, double>& heights = world_->campus().levels;
  const auto rank = [&](const std::string& id) {
    return std::count_if(heights.begin(), heights.end(),
                         [&](const auto& level) { return level.second < heights.at(id); });
  };
  return static_cast<int>(rank(driver_.level()) - rank(start_level_));
}

Noise RobotSimulation::NoiseOf(int sensor, std::int64_t index) const {
  return Noise(Mix(robot_seed_, static_cast<std::uint64_t>(sensor), static_cast<std::uint64_t>(index)));
}

TimeNs RobotSimulation::Now() const {
  return options_.start_time +
         static_cast<DurationNs>(std::llround(static_cast<double>(steps_) / options_.odometry_hz * 1e9));
}

bool RobotSimulation::Due(double hz) const {
  return hz > 0.0 && steps_ % std::max(1L, std::lround(options_.odometry_hz / hz)) == 0;
}

bool RobotSimulation::NearADoor() const {
  if (options_.near_doors <= 0.0) return true;
  const Eigen::Vector2d at = driver_.T_campus_robot().translation();
  return std::any_of(world_->campus().doors.begin(), world_->campus().doors.end(), [&](const Door& door) {
    return door.level == driver_.level() && !door.opening && (door.middle() - at).norm() <= options_.near_doors;
  });
}

// Each wheel measures the distance that it rolls.
void RobotSimulation::MeasureStep(const RouteDriver::Step& step) {
  Noise noise = NoiseOf(kWheels, steps_);
  const auto measured = [&](double way) { return way + options_.slip * std::sqrt(std::abs(way)) * noise.Normal(); };
  const double half = options_.track / 2.0;
  const double left = measured((step.forward - step.turn * half) * left_factor_);
  const double right = measured((step.forward + step.turn * half) * right_factor_);
  T_odom_robot_ = T_odom_robot_ * ArcStep((left + right) / 2.0, (right - left) / options_.track);
}

void RobotSimulation::FindPassages(const Pose2& before) {
  const Pose2& after = driver_.T_campus_robot();
  const Eigen::Vector2d way = after.translation() - before.translation();
  truth_.travelled += way.norm();
  for (const Door& door : world_->campus().doors) {
    if (door.level != driver_.level() || door.opening || door.state != DoorState::kOpen) continue;
    const Eigen::Vector2d edge = door.b - door.a;
    const double cross = way.x() * edge.y() - way.y() * edge.x();
    if (cross == 0.0) continue;
    const Eigen::Vector2d to = door.a - before.translation();
    const double t = (to.x() * edge.y() - to.y() * edge.x()) / cross;
    const double along = (to.x() * way.y() - to.y() * way.x()) / cross;
    if (t < 0.0 || t >= 1.0 || along < 0.0 || along > 1.0) continue;
    Eigen::Vector2d normal = Eigen::Vector2d(edge.y(), -edge.x()).normalized();
    if (normal.dot(way) < 0.0) normal = -normal;
    const Pose2 at = Interpolate(before, after, t);
    const auto area = [&](double beyond) {
      const Area* found = world_->campus().AreaAt(door.level, at.translation() + beyond * normal);
      return found ? found->id : std::string();
    };
    const auto step = static_cast<DurationNs>(std::llround((1.0 - t) / options_.odometry_hz * 1e9));
    truth_.passages.push_back({Now() - step, at, door.level, door.id, area(-kBesideDoor), area(kBesideDoor),
                               door.width(), std::acos(std::clamp(normal.dot(way.normalized()), -1.0, 1.0))});
  }
}

absl::Status RobotSimulation::RecordImages(const Viewpoint& view, TimeNs time) {
  const bool images = Due(options_.image_hz);
  const bool depth = Due(options_.depth_hz);
  if (!images && !depth) return absl::OkStatus();
  const auto add = [&](sensor::Camera camera, sensor::ImageEncoding encoding,
                       absl::StatusOr<std::string> png) -> absl::Status {
    ENFILADE_RETURN_IF_ERROR(png.status());
    sensor::Image image{time, camera, encoding, RefOf(*png)};
    pending_.push_back({image, *std::move(png)});
    return absl::OkStatus();
  };
  const CameraFrame front = ReadCamera(view, options_.camera, NoiseOf(kFrontCamera, steps_));
  if (images) {
    ENFILADE_RETURN_IF_ERROR(add(sensor::Camera::kFront, sensor::ImageEncoding::kPng, front.GreyPng()));
    CameraOptions rear = options_.camera;
    rear.T_robot_camera = Pose2{0.0, 0.0, M_PI} * options_.camera.T_robot_camera;
    ENFILADE_RETURN_IF_ERROR(add(sensor::Camera::kRear, sensor::ImageEncoding::kPng,
                                 ReadCamera(view, rear, NoiseOf(kRearCamera, steps_)).GreyPng()));
  }
  return depth ? add(sensor::Camera::kFront, sensor::ImageEncoding::kDepthPng16, front.DepthPng()) : absl::OkStatus();
}

void RobotSimulation::RecordCloud(const Viewpoint& view, TimeNs time) {
  const std::vector<float> points = ReadCloud(view, options_.cloud, NoiseOf(kCloudScanner, steps_));
  std::string content(points.size() * sizeof(float), '\0');
  std::memcpy(content.data(), points.data(), content.size());
  sensor::PointCloud cloud{time, sensor::CloudEncoding::kXyz32, RefOf(content)};
  pending_.push_back({cloud, std::move(content)});
}

absl::Status RobotSimulation::Record() {
  const TimeNs time = Now();
  pending_.push_back({sensor::Odometry{time, T_odom_robot_}, {}});
  const Viewpoint view{*world_, driver_.level(), driver_.T_campus_robot(),
                       static_cast<double>(steps_) / options_.odometry_hz, driver_.gate()};
  if (Due(options_.scan_hz)) {
    sensor::LaserScan scan = ReadScan(view, options_.scanner, NoiseOf(kScanner, steps_));
    scan.time = time;
    pending_.push_back({std::move(scan), {}});
    const Area* area = world_->campus().AreaAt(view.level, view.T_campus_robot.translation());
    truth_.poses.push_back({time, view.T_campus_robot, view.level, area ? area->id : std::string()});
  }
  if (!NearADoor()) return absl::OkStatus();
  if (Due(options_.cloud_hz)) RecordCloud(view, time);
  return RecordImages(view, time);
}

absl::StatusOr<std::optional<SimulatedRecord>> RobotSimulation::Next() {
  while (pending_.empty()) {
    if (recorded_start_) {
      const Pose2 before = driver_.T_campus_robot();
      ENFILADE_ASSIGN_OR_RETURN(const std::optional<RouteDriver::Step> step, driver_.Next());
      if (!step) return std::nullopt;
      ++steps_;
      MeasureStep(*step);
      FindPassages(before);
    }
    recorded_start_ = true;
    ENFILADE_RETURN_IF_ERROR(Record());
  }
  SimulatedRecord record = std::move(pending_.front());
  pending_.pop_front();
  return record;
}

absl::StatusOr<Drive> SimulateDrive(std::shared_ptr<const World> world, const std::string& robot,
                                    const SimulationOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(RobotSimulation simulation, RobotSimulation::Start(std::move(world), robot, options));
  Drive drive;
  while (true) {
    ENFILADE_ASSIGN_OR_RETURN(std::optional<SimulatedRecord> record, simulation.Next());
    if (!record) break;
    drive.records.push_back(*std::move(record));
  }
  drive.truth = simulation.truth();
  return drive;
}

SimulationOptions RoomsOptions() {
  SimulationOptions options;
  options.scanner.beams = 361;
  options.scanner.field_of_view = 1.5 * M_PI;
  options.scanner.range_max = 12.0;
  options.scanner.T_robot_laser = {0.2, 0.0, 0.0};
  return options;
}

absl::StatusOr<Drive> SimulateRooms(const SimulationOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(Campus campus, ShippedCampus("rooms"));
  return SimulateDrive(std::make_shared<const World>(std::move(campus)), "robot", options);
}

}  // namespace enfilade::simulator
