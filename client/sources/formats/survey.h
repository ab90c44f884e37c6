// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "core/base/time.h"

namespace enfilade::sources {

// Which of a log's times are used. Chosen once for a whole log, so that scans and odometry share one clock.
struct TimeRule {
  enum class Source { kFirst, kSecond, kLineOrder };

  Source source = Source::kFirst;
  DurationNs offset = 0;                 // added to every time read, so that none is negative
  DurationNs period = kNsPerSecond / 2;  // between timed lines, for kLineOrder

  // `index` counts the log's timed lines (scans, odometry) from 0.
  TimeNs Of(TimeNs first, TimeNs second, std::int64_t index) const;
};

// Collects the statistics by which a TimeRule is chosen. A log line has one or two times (CARMEN: the message's and the
// logger's).
class TimeSurvey {
 public:
  void AddScan(TimeNs first, TimeNs second);
  void AddOdometry(TimeNs first, TimeNs second);

  // The first time field whose scan times are usable: more than half of them differ from the previous one and at most a
  // tenth of them run backwards. Otherwise (all zero, garbage) the order of the lines. If the chosen field has times
  // below zero, the whole log is shifted so that the earliest is zero.
  TimeRule Choose() const;

 private:
  struct Column {
    TimeNs last = 0;
    std::int64_t changes = 0;  // scans whose time differs from the previous one's
    std::int64_t reversals = 0;
    TimeNs earliest = 0;
  };
  static bool IsUsable(const Column& column, std::int64_t scans);

  Column columns_[2];
  std::int64_t scans_ = 0;
};

// Finds the range (m) at and above which a log's readings mean "no return", the lowest of
//  - what the log declares (`declared`, if above zero);
//  - the codes that SICK LMS scanners send for "no echo": 8183..8191 cm and 32759..32767 mm;
//  - the start of the top thousandth of the largest reading's scale, where readings pile up: at least 10 there, and 10
//    times as many as in the thousandth below (a saturated reading repeats; a measured maximum does not).
// Without any of them: slightly above the largest reading, so that each reading is a hit.
class RangeSurvey {
 public:
  void Add(const std::vector<float>& ranges);
  float Choose(double declared) const;

 private:
  float largest_ = 0.0F;
  std::map<float, std::int64_t> top_;  // readings within 1 % of the largest
};

}  // namespace enfilade::sources
