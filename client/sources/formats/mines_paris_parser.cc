// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <optional>
#include <utility>

#include "client/sources/formats/fields.h"
#include "client/sources/formats/log_parser.h"
#include "client/sources/formats/timed_log.h"
#include "core/base/status_macros.h"

namespace enfilade::sources {
namespace {

// The robot of Mines ParisTech (Steux, El Hamzaoui: CoreSLAM, ICARCV 2010).
constexpr double kWheelRadius = 0.077;  // m
constexpr double kTrack = 0.33;         // m, between the wheels
constexpr double kTicksPerTurn = 2000.0;
constexpr double kLaserForward = 0.145;  // m, before the axle
// Its scanner, a Hokuyo URG-04LX: 1024 steps a turn, steps 44 to 725 of them delivered, step 384 straight ahead.
constexpr std::int64_t kUrgBeams = 682;
constexpr double kFrontBeam = 340.0;
constexpr double kStep = 2.0 * M_PI / 1024.0;  // rad
constexpr double kReach = 5.6;                 // m; readings below 20 mm are error codes

// Lines of 707 fields: time in microseconds, an unused field, left and right wheel ticks, 20 unused fields, 682 ranges
// in millimetres, an unused field.
class MinesParisParser : public LogParser {
 public:
  explicit MinesParisParser(const LogOptions& options) : options_(options), log_(options) {}

  void Survey(std::string_view line) override {
    const absl::StatusOr<Reading> reading = Read(line);
    if (reading.ok()) log_.Survey(reading->line);
  }

  void Conclude(LogFacts& facts) override {
    log_.Conclude({.known_range_max = kReach, .declared_range_max = 0.0}, kLineTimeNames, facts);
  }

  absl::StatusOr<ParsedLine> Parse(std::string_view line) override {
    ENFILADE_ASSIGN_OR_RETURN(Reading reading, Read(line));
    Advance(reading.left_ticks, reading.right_ticks);
    reading.line.odometry->T_odom_robot = T_odom_robot_;
    ParsedLine parsed;
    parsed.entries = log_.Deliver(std::move(reading.line));
    return parsed;
  }

 private:
  struct Reading {
    TimedLine line;
    std::int64_t left_ticks = 0;
    std::int64_t right_ticks = 0;
  };

  static absl::StatusOr<Reading> Read(std::string_view line) {
    Fields fields(line);
    Reading reading;
    const double microseconds = fields.Number("time in us");
    fields.Skip("unused", 1);
    reading.left_ticks = fields.Integer("left wheel ticks");
    reading.right_ticks = fields.Integer("right wheel ticks");
    fields.Skip("unused", 20);
    sensor::LaserScan scan;
    scan.ranges = fields.Ranges("range", kUrgBeams, 1e-3);
    fields.Skip("unused", 1);
    fields.ExpectEnd();
    if (!fields.ok()) return fields.status();
    scan.angle_min = -kFrontBeam * kStep;
    scan.angle_increment = kStep;
    scan.T_robot_laser = {kLaserForward, 0.0, 0.0};
    reading.line.first_time = reading.line.second_time = static_cast<TimeNs>(microseconds) * 1000;
    reading.line.odometry.emplace();
    reading.line.scan = std::move(scan);
    return reading;
  }

  // Dead reckoning of a differential drive; over one line's step the arc's chord points half-way.
  void Advance(std::int64_t left_ticks, std::int64_t right_ticks) {
    if (previous_ticks_) {
      const double metres_per_tick = 2.0 * M_PI * kWheelRadius / kTicksPerTurn;
      const double left = static_cast<double>(left_ticks - previous_ticks_->first) * metres_per_tick;
      const double right = static_cast<double>(right_ticks - previous_ticks_->second) * metres_per_tick;
      const double turn = (right - left) / kTrack;
      const double forward = (left + right) / 2.0;
      T_odom_robot_ = T_odom_robot_ * Pose2{forward * std::cos(turn / 2.0), forward * std::sin(turn / 2.0), turn};
    }
    previous_ticks_ = {left_ticks, right_ticks};
  }

  LogOptions options_;
  TimedLog log_;
  Pose2 T_odom_robot_;
  std::optional<std::pair<std::int64_t, std::int64_t>> previous_ticks_;
};

}  // namespace

std::unique_ptr<LogParser> NewMinesParisParser(const LogOptions& options) {
  return std::make_unique<MinesParisParser>(options);
}

}  // namespace enfilade::sources
