// SPDX-License-Identifier: Apache-2.0
#include "client/sources/formats/survey.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace enfilade::sources {
namespace {

constexpr std::size_t kMaxTopReadings = 65'536;

// What a SICK LMS sends for "no echo", in metres: 13 bits of centimetres, 15 bits of millimetres. Neither scanner
// measures that far.
struct NoEchoCodes {
  float first;
  float last;
};
constexpr NoEchoCodes kNoEchoCodes[] = {{81.83F, 81.91F}, {32.759F, 32.767F}};

}  // namespace

TimeNs TimeRule::Of(TimeNs first, TimeNs second, std::int64_t index) const {
  switch (source) {
    case Source::kFirst:
      return first + offset;
    case Source::kSecond:
      return second + offset;
    case Source::kLineOrder:
      return index * period;
  }
  return 0;
}

void TimeSurvey::AddScan(TimeNs first, TimeNs second) {
  const TimeNs times[2] = {first, second};
  for (int i = 0; i < 2; ++i) {
    Column& column = columns_[i];
    if (scans_ > 0 && times[i] < column.last) ++column.reversals;
    if (scans_ > 0 && times[i] != column.last) ++column.changes;
    column.last = times[i];
  }
  ++scans_;
  AddOdometry(first, second);
}

void TimeSurvey::AddOdometry(TimeNs first, TimeNs second) {
  columns_[0].earliest = std::min(columns_[0].earliest, first);
  columns_[1].earliest = std::min(columns_[1].earliest, second);
}

bool TimeSurvey::IsUsable(const Column& column, std::int64_t scans) {
  return scans < 2 || (2 * column.changes > scans - 1 && 10 * column.reversals <= scans);
}

TimeRule TimeSurvey::Choose() const {
  TimeRule rule;
  for (int i = 0; i < 2; ++i) {
    if (!IsUsable(columns_[i], scans_)) continue;
    rule.source = i == 0 ? TimeRule::Source::kFirst : TimeRule::Source::kSecond;
    rule.offset = -columns_[i].earliest;  // 0 where no time is negative
    return rule;
  }
  rule.source = TimeRule::Source::kLineOrder;
  return rule;
}

void RangeSurvey::Add(const std::vector<float>& ranges) {
  for (const float range : ranges) {
    if (!std::isfinite(range) || range < 0.99F * largest_ || range <= 0.0F) continue;
    if (range > largest_) {
      largest_ = range;
      top_.erase(top_.begin(), top_.lower_bound(0.99F * largest_));
    }
    ++top_[range];
    if (top_.size() > kMaxTopReadings) top_.erase(top_.begin());
  }
}

float RangeSurvey::Choose(double declared) const {
  float result = std::numeric_limits<float>::infinity();
  if (declared > 0.0) result = static_cast<float>(declared);
  for (const NoEchoCodes& codes : kNoEchoCodes) {
    const auto code = top_.lower_bound(codes.first);
    if (code != top_.end() && largest_ <= codes.last) result = std::min(result, codes.first);
  }
  const float pile_start = 0.999F * largest_;
  std::int64_t in_pile = 0;
  std::int64_t below = 0;
  float lowest_in_pile = largest_;
  for (const auto& [range, count] : top_) {
    if (range >= pile_start) {
      lowest_in_pile = std::min(lowest_in_pile, range);
      in_pile += count;
    } else if (range >= 0.998F * largest_) {
      below += count;
    }
  }
  if (in_pile >= 10 && in_pile >= 10 * below) result = std::min(result, lowest_in_pile);
  if (std::isfinite(result)) return result;
  return std::max(1.0F, 1.001F * largest_);
}

}  // namespace enfilade::sources
