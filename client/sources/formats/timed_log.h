// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "client/sources/formats/log_parser.h"
#include "client/sources/formats/survey.h"

namespace enfilade::sources {

// The content of one line of a log that needs a survey: odometry, a scan, or both. TimedLog sets their times.
struct TimedLine {
  TimeNs first_time = 0;
  TimeNs second_time = 0;  // the same as the first if the format has only one time
  std::optional<sensor::Odometry> odometry;
  std::optional<sensor::LaserScan> scan;
  double declared_range_max = 0.0;  // m, of the scan; 0: unknown
};

// The names of the time fields in messages, for formats with one time a line.
constexpr const char* kLineTimeNames[2] = {"the line's time", "the line's time"};

// What the older formats share: one clock and one "no return" range for the whole log, chosen from all of its lines
// (survey.h) and then applied line by line.
class TimedLog {
 public:
  explicit TimedLog(const LogOptions& options) : options_(options) {}

  void Survey(const TimedLine& line);
  struct RangeLimits {
    std::optional<double> known_range_max;  // m, of the format's only scanner; unset: found from the readings
    double declared_range_max = 0.0;        // m, in the log's parameters; 0: unknown
  };
  // `time_names`: the names of the two time fields.
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

// Sets the angles of a scanner that covers half a circle, like SICK's. The increment is 180 degrees / n for an even
// number of beams (180, 360: the last beam is left out) and 180 degrees / (n - 1) for an odd one (181, 361). Beam 0
// points to the right, -90 degrees. 400 and 401 beams are the same scanners' quarter-degree mode over 100 degrees.
// docs/logs.md explains how this was verified. options.field_of_view replaces the 180 or 100 degrees.
void SetSickAngles(const LogOptions& options, sensor::LaserScan& scan);

}  // namespace enfilade::sources
