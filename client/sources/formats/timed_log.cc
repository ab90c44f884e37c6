// SPDX-License-Identifier: Apache-2.0
#include "client/sources/formats/timed_log.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "fmt/format.h"

namespace enfilade::sources {
namespace {

std::string Describe(const TimeRule& rule, const char* const (&names)[2]) {
  if (rule.source == TimeRule::Source::kLineOrder) {
    return fmt::format("the log's times are unusable: {} s from line to line instead", ToSeconds(rule.period));
  }
  const char* name = names[rule.source == TimeRule::Source::kFirst ? 0 : 1];
  if (rule.offset == 0) return name;
  return fmt::format("{}, shifted by {} s so that none is negative", name, ToSeconds(rule.offset));
}

}  // namespace

void TimedLog::Survey(const TimedLine& line) {
  if (line.scan) {
    ++scans_;
    time_survey_.AddScan(line.first_time, line.second_time);
    range_survey_.Add(line.scan->ranges);
  } else {
    time_survey_.AddOdometry(line.first_time, line.second_time);
  }
  if (line.odometry) ++odometry_;
}

void TimedLog::Conclude(const RangeLimits& limits, const char* const (&time_names)[2], LogFacts& facts) {
  time_rule_ = time_survey_.Choose();
  const std::optional<double> known = options_.range_max ? options_.range_max : limits.known_range_max;
  range_max_ = known ? static_cast<float>(*known) : range_survey_.Choose(limits.declared_range_max);
  facts.scans = scans_;
  facts.entries = scans_ + (options_.odometry ? odometry_ : 0);
  facts.range_max = range_max_;
  facts.times = Describe(time_rule_, time_names);
  facts.synthetic_times = time_rule_.source == TimeRule::Source::kLineOrder;
}

std::vector<LogEntry> TimedLog::Deliver(TimedLine line) {
  const TimeNs time = time_rule_.Of(line.first_time, line.second_time, delivered_lines_++);
  std::vector<LogEntry> entries;
  if (line.odometry && options_.odometry) {
    line.odometry->time = time;
    entries.push_back({*line.odometry, {}});
  }
  if (line.scan) {
    sensor::LaserScan& scan = *line.scan;
    scan.time = time;
    scan.range_min = kRangeMin;
    scan.range_max = range_max_;
    if (line.declared_range_max > 0.0 && !options_.range_max) {
      scan.range_max = std::min(range_max_, static_cast<float>(line.declared_range_max));
    }
    entries.push_back({std::move(scan), {}});
  }
  return entries;
}

void SetSickAngles(const LogOptions& options, sensor::LaserScan& scan) {
  const std::size_t beams = scan.ranges.size();
  const bool quarter_degrees = beams == 400 || beams == 401;
  const double field_of_view = options.field_of_view.value_or((quarter_degrees ? 100.0 : 180.0) * M_PI / 180.0);
  const std::size_t steps = beams % 2 == 0 || beams == 1 ? beams : beams - 1;
  scan.angle_min = -field_of_view / 2.0;
  scan.angle_increment = field_of_view / static_cast<double>(steps);
}

}  // namespace enfilade::sources
