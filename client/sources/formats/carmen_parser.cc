// SPDX-License-Identifier: Apache-2.0
#include <string>

#include "client/sources/formats/fields.h"
#include "client/sources/formats/log_parser.h"
#include "client/sources/formats/timed_log.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace enfilade::sources {
namespace {

constexpr const char* kCarmenTimeNames[2] = {"ipc_timestamp", "logger_timestamp"};

// CARMEN's logs (carmen.sourceforge.net, "Logger / Playback").
class CarmenParser : public LogParser {
 public:
  explicit CarmenParser(const LogOptions& options) : options_(options), log_(options) {}

  void Survey(std::string_view line) override {
    const absl::StatusOr<TimedLine> read = Read(line);
    if (read.ok() && (read->scan || read->odometry)) log_.Survey(*read);
  }

  void Conclude(LogFacts& facts) override {
    log_.Conclude({.known_range_max = std::nullopt, .declared_range_max = declared_range_max_}, kCarmenTimeNames,
                  facts);
  }

  absl::StatusOr<ParsedLine> Parse(std::string_view line) override {
    ENFILADE_ASSIGN_OR_RETURN(TimedLine read, Read(line));
    ParsedLine parsed;
    if (read.scan || read.odometry) {
      parsed.entries = log_.Deliver(std::move(read));
    } else {
      parsed.skipped_tag = std::string(Fields(line).Word("tag"));
    }
    return parsed;
  }

 private:
  absl::StatusOr<TimedLine> Read(std::string_view line) {
    Fields fields(line);
    const std::string_view tag = fields.Word("tag");
    TimedLine read;
    if (tag == "FLASER") {
      ReadFrontLaser(fields, read);
    } else if (tag == "ROBOTLASER1") {
      ReadRobotLaser(fields, read);
    } else if (tag == "ODOM") {
      ReadOdometry(fields, read);
    } else if (tag == "PARAM") {
      ReadParameter(fields);
      return read;
    } else {
      return read;  // RLASER, NEFF, SYNC, TRUEPOS, ...
    }
    if (!fields.ok()) return WithContext(fields.status(), std::string(tag));
    return read;
  }

  // FLASER n ranges.. x y theta odom_x odom_y odom_theta ipc_timestamp hostname logger_timestamp
  void ReadFrontLaser(Fields& fields, TimedLine& read) {
    sensor::LaserScan scan;
    const std::int64_t beams = fields.Integer("number of ranges");
    if (beams > 0 && beams <= static_cast<std::int64_t>(sensor::kMaxBeams)) {
      fields.ExpectRemaining(beams + 9, fmt::format("{} ranges are announced", beams));
    }
    scan.ranges = fields.Ranges("range", beams);
    fields.Pose("laser pose");
    read.odometry.emplace().T_odom_robot = fields.Pose("odometry");
    ReadTimes(fields, read);
    SetSickAngles(options_, scan);
    scan.T_robot_laser = {front_offset_, 0.0, 0.0};
    read.scan = std::move(scan);
  }

  // ROBOTLASER1 laser_type start_angle field_of_view angular_resolution maximum_range accuracy remission_mode
  // n ranges.. m remissions.. laser_x laser_y laser_theta robot_x robot_y robot_theta laser_tv laser_rv
  // forward_safety_dist side_safety_dist turn_axis ipc_timestamp hostname logger_timestamp
  static void ReadRobotLaser(Fields& fields, TimedLine& read) {
    sensor::LaserScan scan;
    fields.Word("laser_type");
    scan.angle_min = fields.Number("start_angle");
    fields.Number("field_of_view");
    scan.angle_increment = fields.Number("angular_resolution");
    read.declared_range_max = fields.Number("maximum_range");
    fields.Number("accuracy");
    fields.Word("remission_mode");
    scan.ranges = fields.Ranges("range", fields.Integer("number of ranges"));
    fields.Skip("remission", fields.Integer("number of remissions"));
    const Pose2 T_odom_laser = fields.Pose("laser pose");
    const Pose2 T_odom_robot = fields.Pose("robot pose");
    for (const char* name : {"laser_tv", "laser_rv", "forward_safety_dist", "side_safety_dist", "turn_axis"}) {
      fields.Number(name);
    }
    ReadTimes(fields, read);
    scan.T_robot_laser = Between(T_odom_robot, T_odom_laser);
    read.odometry.emplace().T_odom_robot = T_odom_robot;
    read.scan = std::move(scan);
  }

  // ODOM x y theta tv rv accel ipc_timestamp hostname logger_timestamp
  static void ReadOdometry(Fields& fields, TimedLine& read) {
    read.odometry.emplace().T_odom_robot = fields.Pose("pose");
    for (const char* name : {"tv", "rv", "accel"}) fields.Number(name);
    ReadTimes(fields, read);
  }

  static void ReadTimes(Fields& fields, TimedLine& read) {
    read.first_time = fields.Seconds("ipc_timestamp");
    fields.Word("ipc_hostname");
    read.second_time = fields.Seconds("logger_timestamp");
    fields.ExpectEnd();
  }

  // PARAM name value ...: only the front laser's offset and range are used, and only if they are numbers.
  void ReadParameter(Fields& fields) {
    const std::string_view name = fields.Word("name");
    const bool is_offset = name == "robot_frontlaser_offset";
    const bool is_range = name == "robot_front_laser_max" || name == "robot_frontlaser_max" ||
                          name == "laser_front_laser_max" || name == "laser_laser1_max";
    if (!is_offset && !is_range) return;
    const double value = fields.Number("value");
    if (fields.ok()) (is_offset ? front_offset_ : declared_range_max_) = value;
  }

  LogOptions options_;
  TimedLog log_;
  double front_offset_ = 0.0;        // m, of the front laser ahead of the robot's centre
  double declared_range_max_ = 0.0;  // m
};

}  // namespace

std::unique_ptr<LogParser> NewCarmenParser(const LogOptions& options) {
  return std::make_unique<CarmenParser>(options);
}

}  // namespace enfilade::sources
