// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <utility>

#include "client/sources/formats/fields.h"
#include "client/sources/formats/log_parser.h"
#include "client/sources/formats/timed_log.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace enfilade::sources {
namespace {

constexpr double kMetresPerCentimetre = 0.01;
constexpr std::int64_t kSickBeams = 180;

// The logs of CMU's particle filter course in Wean Hall, lengths in centimetres:
//   O x y theta ts                                            odometry
//   L x y theta laser_x laser_y laser_theta 180 ranges ts     a scan, with odometry of robot and laser
class WeanHallParser : public LogParser {
 public:
  explicit WeanHallParser(const LogOptions& options) : options_(options), log_(options) {}

  void Survey(std::string_view line) override {
    const absl::StatusOr<TimedLine> read = Read(line);
    if (read.ok()) log_.Survey(*read);
  }

  void Conclude(LogFacts& facts) override { log_.Conclude({}, kLineTimeNames, facts); }

  absl::StatusOr<ParsedLine> Parse(std::string_view line) override {
    ENFILADE_ASSIGN_OR_RETURN(TimedLine read, Read(line));
    ParsedLine parsed;
    parsed.entries = log_.Deliver(std::move(read));
    return parsed;
  }

 private:
  absl::StatusOr<TimedLine> Read(std::string_view line) const {
    Fields fields(line);
    const std::string_view tag = fields.Word("tag");
    if (tag != "O" && tag != "L")
      return InvalidArgument("the line begins with \"{}\": expected O or L", tag.substr(0, 20));
    TimedLine read;
    const Pose2 T_odom_robot = fields.Pose("robot pose", kMetresPerCentimetre);
    read.odometry.emplace().T_odom_robot = T_odom_robot;
    if (tag == "L") {
      sensor::LaserScan scan;
      scan.T_robot_laser = Between(T_odom_robot, fields.Pose("laser pose", kMetresPerCentimetre));
      scan.ranges = fields.Ranges("range", kSickBeams, kMetresPerCentimetre);
      SetSickAngles(options_, scan);
      read.scan = std::move(scan);
    }
    read.first_time = read.second_time = fields.Seconds("time");
    fields.ExpectEnd();
    if (!fields.ok()) return WithContext(fields.status(), std::string(tag));
    return read;
  }

  LogOptions options_;
  TimedLog log_;
};

}  // namespace

std::unique_ptr<LogParser> NewWeanHallParser(const LogOptions& options) {
  return std::make_unique<WeanHallParser>(options);
}

}  // namespace enfilade::sources
