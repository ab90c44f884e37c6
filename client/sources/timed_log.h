// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "client/sources/log_parser.h"
#include "client/sources/survey.h"

namespace enfilade::sources {

// What one line of a log that needs a survey says: odometry, a scan, or both. Their times are set by TimedLog.
struct TimedLine {
  TimeNs first_time = 0;
  TimeNs second_time = 0;  // the same as the first where the format has one time only
  std::optional<sensor::Odometry> odometry;
  std::optional<sensor::LaserScan> scan;
  double declared_range_max = 0.0;  // m, of the scan; 0 where unknown
};

// The time fields' names in messages, of formats with one time a line.
constexpr const char* kLineTimeNames[2] = {"the line's time", "the line's time"};

// The rules that the older formats share: one clock and one "no return" range for the whole log, chosen from all of
// its lines (survey.h), then applied line by line.
class TimedLog {
 public:
  explicit TimedLog(const LogOptions& options) : options_(options) {}

  void Survey(const TimedLine& line);
  // `known_range_max`, m: the scanner's, where the format has one only; otherwise it is found among the readings and
  // `declared_range_max`, m, by the log's parameters (0 where unknown). `time_names`: of the two time fields, in words.
  struct RangeLimits {
    std::optional<double> known_range_max;
    double declared_range_max = 0.0;
  };
  void Conclude(const RangeLimits& limits, const char* const (&time_names)[2], LogFacts& facts);
  // Odometry first, then the scan, at the same time.
  std::vector<LogEntry> Deliver(TimedLine line);

 private:
  LogOptions options_;
  TimeSurvey time_survey_;
  RangeSurvey range_survey_;
  std::int64_t scans_ = 0;
  std::int64_t odometry_ = 0;
  TimeRule time_rule_;
  float range_max_ = 0.0F;
  std::int64_t delivered_lines_ = 0;
};

// Increment between the beams of a scanner that looks over half a circle, as SICK's does: 180 degrees / n for an even
// count (180, 360: the last beam is left out), 180 degrees / (n - 1) for an odd one (181, 361). Beam 0 points to the
// right, -90 degrees. 400 and 401 beams are the same scanners' quarter-degree mode over 100 degrees. docs/logs.md tells
// how this was checked. With `field_of_view` (rad) that angle instead of 180 degrees.
void SetSickAngles(const LogOptions& options, sensor::LaserScan& scan);

}  // namespace enfilade::sources
