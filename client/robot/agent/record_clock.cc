// SPDX-License-Identifier: Apache-2.0
#include "client/robot/agent/record_clock.h"

#include <algorithm>
#include <cstdlib>

namespace enfilade::robot {
namespace {

// Records of one series that are out of order by less are late, not of another clock.
constexpr DurationNs kLate = kNsPerSecond;
// A record that is farther ahead must be confirmed by the next one.
constexpr DurationNs kFar = 60 * kNsPerSecond;

}  // namespace

std::optional<TimeNs> RecordClock::Adjust(int series, TimeNs time) {
  TimeNs adjusted = time + ahead_;
  if (newest_ && adjusted > *newest_ + kFar) {
    const bool confirmed = far_ && std::abs(adjusted - *far_) < kFar;
    far_ = adjusted;
    if (!confirmed) return std::nullopt;
  }
  far_.reset();
  const auto [found, first] = series_.try_emplace(series, Series{adjusted, 0, {}});
  Series& one = found->second;
  if (!first) {
    if (adjusted < one.last - kLate) {
      const bool runs_on = one.back && adjusted > *one.back;
      one.back = adjusted;
      if (!runs_on) return std::nullopt;
      const TimeNs expected = one.last + 2 * one.period;
      ahead_ += expected - adjusted;
      adjusted = expected;
    }
    one.back.reset();
    if (adjusted < one.last) return std::nullopt;
    if (adjusted > one.last) one.period = adjusted - one.last;
    one.last = adjusted;
  }
  newest_ = std::max(newest_.value_or(adjusted), adjusted);
  return adjusted;
}

}  // namespace enfilade::robot
