// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>

#include "core/base/time.h"

namespace enfilade::robot {

// Keeps the times of a robot's records in order when its clock is set. Maps depend on the order and the distances of
// times only, so times continue as if the clock had not been set back: they are then ahead of the clock. Pure.
class RecordClock {
 public:
  // The time to record for a record of `series` (scans, odometry, images of one camera, ...) with this time. Unset: do
  // not record it. It is a little older than its predecessor, or its clock has been set (or runs backwards), which the
  // next record has to confirm.
  std::optional<TimeNs> Adjust(int series, TimeNs time);
  // How far recorded times are ahead of the robot's clock.
  DurationNs ahead() const { return ahead_; }

 private:
  struct Series {
    TimeNs last = 0;             // adjusted
    DurationNs period = 0;       // between the last two
    std::optional<TimeNs> back;  // much older than `last`; not confirmed
  };
  std::map<int, Series> series_;
  std::optional<TimeNs> newest_;  // of all series, adjusted
  std::optional<TimeNs> far_;     // not confirmed
  DurationNs ahead_ = 0;
};

}  // namespace enfilade::robot
