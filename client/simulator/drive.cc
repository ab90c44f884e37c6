#include "client/simulator/drive.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "client/simulator/noise.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace enfilade::simulator {
namespace {

constexpr double kArrived = 0.15;  // m, near enough to a point of the route to head for the next

// One step of a robot on two wheels: along an arc.
Pose2 Step(double forward, double turn) {
  return {forward * std::cos(turn / 2.0), forward * std::sin(turn / 2.0), turn};
}

// What the wheels report of a true step.
class WheelOdometry {
 public:
  WheelOdometry(const DriveOptions& options, Noise& noise)
      : options_(options),
        noise_(noise),
        left_factor_(1.0 + options.wheel_sigma * noise.Normal()),
        right_factor_(1.0 + options.wheel_sigma * noise.Normal()) {}

  void Advance(double forward, double turn) {
    const double left = Measured((forward - turn * options_.track / 2.0) * left_factor_);
    const double right = Measured((forward + turn * options_.track / 2.0) * right_factor_);
    T_odom_robot_ = T_odom_robot_ * Step((left + right) / 2.0, (right - left) / options_.track);
  }
  const Pose2& T_odom_robot() const { return T_odom_robot_; }

 private:
  double Measured(double way) { return way + options_.slip * std::sqrt(std::abs(way)) * noise_.Normal(); }

  const DriveOptions& options_;
  Noise& noise_;
  double left_factor_;
  double right_factor_;
  Pose2 T_odom_robot_;
};

LaserScan ScanAt(const FloorPlan& plan, const DriveOptions& options, const Pose2& T_plan_robot, Noise& noise) {
  LaserScan scan;
  scan.angle_min = -options.field_of_view / 2.0;
  scan.angle_increment = options.field_of_view / (options.beams - 1);
  scan.range_min = 0.05F;
  scan.range_max = static_cast<float>(options.range_max);
  scan.T_robot_laser = options.T_robot_laser;
  const Pose2 T_plan_laser = T_plan_robot * options.T_robot_laser;
  scan.ranges.reserve(static_cast<std::size_t>(options.beams));
  for (int i = 0; i < options.beams; ++i) {
    const double bearing = T_plan_laser.yaw + scan.angle(static_cast<std::size_t>(i));
    const Eigen::Vector2d direction(std::cos(bearing), std::sin(bearing));
    const double distance = plan.DistanceToWall(T_plan_laser.translation(), direction, options.range_max);
    const double error = options.range_sigma * noise.Normal();
    float range = std::numeric_limits<float>::infinity();
    if (distance < options.range_max) range = static_cast<float>(std::max(0.0, distance + error));
    if (noise.Uniform() < options.dropout) range = std::numeric_limits<float>::quiet_NaN();
    scan.ranges.push_back(range);
  }
  return scan;
}

class Simulation {
 public:
  Simulation(const FloorPlan& plan, const DriveOptions& options)
      : plan_(plan), options_(options), noise_(options.seed), wheels_(options_, noise_) {
    const Eigen::Vector2d start = plan.route()[0];
    const Eigen::Vector2d first_leg = plan.route()[1] - start;
    T_plan_robot_ = {start.x(), start.y(), std::atan2(first_leg.y(), first_leg.x())};
  }

  absl::StatusOr<Drive> Run() && {
    Record();
    const std::size_t points = plan_.route().size();
    for (int lap = 0; lap < options_.laps; ++lap) {
      for (std::size_t i = 1; i <= points; ++i) ENFILADE_RETURN_IF_ERROR(DriveTo(plan_.route()[i % points]));
    }
    return std::move(drive_);
  }

 private:
  absl::Status DriveTo(const Eigen::Vector2d& target) {
    const double dt = 1.0 / options_.odometry_hz;
    while ((target - T_plan_robot_.translation()).norm() > kArrived) {
      const Eigen::Vector2d way = target - T_plan_robot_.translation();
      const double off_course = WrapAngle(std::atan2(way.y(), way.x()) - T_plan_robot_.yaw);
      const double turn = std::clamp(2.0 * off_course, -options_.turn_rate, options_.turn_rate) * dt;
      // Off course the robot slows down, and far off it turns on the spot.
      const double forward = options_.speed * std::max(0.0, 1.0 - std::abs(off_course) / 0.8) * dt;
      T_plan_robot_ = T_plan_robot_ * Step(forward, turn);
      wheels_.Advance(forward, turn);
      ++steps_;
      if (plan_.IsWallAt(T_plan_robot_.translation())) {
        return FailedPrecondition("the route runs into a wall at ({:.2f}, {:.2f}) m", T_plan_robot_.x, T_plan_robot_.y);
      }
      Record();
    }
    return absl::OkStatus();
  }

  void Record() {
    const auto time = options_.start_time +
                      static_cast<DurationNs>(std::llround(static_cast<double>(steps_) / options_.odometry_hz * 1e9));
    drive_.entries.push_back({Odometry{time, wheels_.T_odom_robot()}, {}});
    if (steps_ % std::lround(options_.odometry_hz / options_.scan_hz) != 0) return;
    LaserScan scan = ScanAt(plan_, options_, T_plan_robot_, noise_);
    scan.time = time;
    drive_.entries.push_back({std::move(scan), {}});
    drive_.truth.push_back({time, T_plan_robot_});
  }

  const FloorPlan& plan_;
  DriveOptions options_;
  Noise noise_;
  WheelOdometry wheels_;
  Pose2 T_plan_robot_;
  std::int64_t steps_ = 0;
  Drive drive_;
};

}  // namespace

absl::Status DriveOptions::Validate() const {
  const auto positive = [](const char* name, double value) {
    if (value > 0.0 && std::isfinite(value)) return absl::OkStatus();
    return InvalidArgument("{} is {}: expected above 0", name, value);
  };
  if (laps < 1 || laps > 1000) return InvalidArgument("laps is {}: expected 1 to 1000", laps);
  if (beams < 2 || beams > static_cast<int>(kMaxBeams))
    return InvalidArgument("beams is {}: expected 2 to {}", beams, kMaxBeams);
  ENFILADE_RETURN_IF_ERROR(positive("speed", speed));
  ENFILADE_RETURN_IF_ERROR(positive("turn_rate", turn_rate));
  ENFILADE_RETURN_IF_ERROR(positive("odometry_hz", odometry_hz));
  ENFILADE_RETURN_IF_ERROR(positive("scan_hz", scan_hz));
  ENFILADE_RETURN_IF_ERROR(positive("field_of_view", field_of_view));
  ENFILADE_RETURN_IF_ERROR(positive("range_max", range_max));
  ENFILADE_RETURN_IF_ERROR(positive("track", track));
  if (scan_hz > odometry_hz) return InvalidArgument("scan_hz is {}: above odometry_hz {}", scan_hz, odometry_hz);
  if (speed / odometry_hz > kArrived) return InvalidArgument("speed is {} m/s: too fast for {} Hz", speed, odometry_hz);
  return absl::OkStatus();
}

absl::StatusOr<Drive> SimulateDrive(const FloorPlan& plan, const DriveOptions& options) {
  ENFILADE_RETURN_IF_ERROR(options.Validate());
  return Simulation(plan, options).Run();
}

}  // namespace enfilade::simulator
