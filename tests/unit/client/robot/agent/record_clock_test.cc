// SPDX-License-Identifier: Apache-2.0
#include "client/robot/agent/record_clock.h"

#include <gtest/gtest.h>

namespace enfilade::robot {
namespace {

constexpr int kScanSeries = 0;
constexpr int kOdometrySeries = 1;
constexpr TimeNs kBegin = 1'700'000'000 * kNsPerSecond;
constexpr DurationNs kDay = 24 * 3600 * kNsPerSecond;

TimeNs ClockAt(double seconds) { return kBegin + static_cast<TimeNs>(seconds * 1e9); }

// Odometry every 0.1 s and a scan every 0.5 s, by a clock that is `off`; expects that times continue.
void RecordBy(RecordClock& clock, double from, double to, DurationNs off) {
  for (int i = static_cast<int>(10.0 * from); i < static_cast<int>(10.0 * to); ++i) {
    EXPECT_EQ(clock.Adjust(kOdometrySeries, ClockAt(i / 10.0) + off), ClockAt(i / 10.0)) << i;
    if (i % 5 != 0) continue;
    EXPECT_EQ(clock.Adjust(kScanSeries, ClockAt(i / 10.0) + off), ClockAt(i / 10.0)) << i;
  }
}

TEST(RecordClock, LeavesTimesAsTheyAre) {
  RecordClock clock;
  RecordBy(clock, 0.0, 30.0, 0);
  EXPECT_EQ(clock.Adjust(kOdometrySeries, ClockAt(50.0)), ClockAt(50.0)) << "a pause";
  EXPECT_EQ(clock.ahead(), 0);
}

TEST(RecordClock, TimesContinueWhenTheClockIsSetBack) {
  RecordClock clock;
  RecordBy(clock, 0.0, 30.0, 0);
  EXPECT_FALSE(clock.Adjust(kOdometrySeries, ClockAt(20.0))) << "not confirmed";
  EXPECT_FALSE(clock.Adjust(kScanSeries, ClockAt(20.0)));
  RecordBy(clock, 30.1, 60.0, -10 * kNsPerSecond);
  EXPECT_EQ(clock.ahead(), 10 * kNsPerSecond);
  EXPECT_FALSE(clock.Adjust(kOdometrySeries, ClockAt(60.0) - kDay));
  EXPECT_FALSE(clock.Adjust(kScanSeries, ClockAt(60.0) - kDay));
  RecordBy(clock, 60.1, 70.0, -kDay);
  EXPECT_EQ(clock.ahead(), kDay);
}

TEST(RecordClock, FollowsAClockThatIsSetForward) {
  RecordClock clock;
  RecordBy(clock, 0.0, 30.0, 0);
  EXPECT_FALSE(clock.Adjust(kOdometrySeries, ClockAt(30.0) + kDay)) << "not confirmed";
  EXPECT_EQ(clock.Adjust(kScanSeries, ClockAt(30.0) + kDay), ClockAt(30.0) + kDay);
  EXPECT_EQ(clock.Adjust(kOdometrySeries, ClockAt(30.1) + kDay), ClockAt(30.1) + kDay);
  EXPECT_EQ(clock.ahead(), 0);
}

TEST(RecordClock, OneRecordWithAWrongTimeIsRefused) {
  RecordClock clock;
  RecordBy(clock, 0.0, 30.0, 0);
  EXPECT_FALSE(clock.Adjust(kOdometrySeries, ClockAt(30.0) + kDay));
  RecordBy(clock, 30.0, 40.0, 0);
  EXPECT_EQ(clock.ahead(), 0);
}

TEST(RecordClock, OfAClockThatRunsBackwardsNothingIsRecorded) {
  RecordClock clock;
  EXPECT_TRUE(clock.Adjust(kOdometrySeries, ClockAt(100.0)));
  for (int i = 1; i < 900; ++i) EXPECT_FALSE(clock.Adjust(kOdometrySeries, ClockAt(100.0 - 0.1 * i))) << i;
}

TEST(RecordClock, ALateRecordIsRefusedAndChangesNothing) {
  RecordClock clock;
  RecordBy(clock, 0.0, 30.0, 0);
  EXPECT_FALSE(clock.Adjust(kOdometrySeries, ClockAt(29.5)));
  EXPECT_EQ(clock.Adjust(kScanSeries, ClockAt(29.9)), ClockAt(29.9)) << "of another series";
  RecordBy(clock, 30.0, 40.0, 0);
}

}  // namespace
}  // namespace enfilade::robot
