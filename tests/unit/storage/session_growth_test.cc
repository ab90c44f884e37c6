// SPDX-License-Identifier: Apache-2.0
#include "storage/sessions/session_growth.h"

#include "gtest/gtest.h"

namespace enfilade::storage {
namespace {

sensor::Record RecordAt(std::int64_t sequence, TimeNs time) { return {sequence, sensor::Odometry{time, {}}}; }

SessionGrowth GrowthFrom(std::int64_t acknowledged, std::int64_t highest) {
  SessionGrowth growth;
  growth.acknowledged = acknowledged;
  growth.highest = highest;
  return growth;
}

TEST(SessionGrowthTest, AdvancesWithRecordsThatJoinOn) {
  SessionGrowth growth = GrowthFrom(5, 5);
  growth.Add(RecordAt(6, 10), 100);
  growth.Add(RecordAt(7, 20), 100);
  EXPECT_EQ(growth.acknowledged, 7);
  EXPECT_EQ(growth.highest, 7);
  EXPECT_FALSE(growth.filled_hole);
  EXPECT_EQ(growth.payload_bytes, 200);
  EXPECT_EQ(growth.counts.odometry, 2);
}

TEST(SessionGrowthTest, StopsBeforeAHole) {
  SessionGrowth growth = GrowthFrom(5, 5);
  growth.Add(RecordAt(6, 10), 1);
  growth.Add(RecordAt(8, 20), 1);
  EXPECT_EQ(growth.acknowledged, 6);
  EXPECT_EQ(growth.highest, 8);
  EXPECT_FALSE(growth.filled_hole);
}

TEST(SessionGrowthTest, SaysThatTheRecordBehindTheAcknowledgedOneCameWhileOthersWereBeyond) {
  SessionGrowth growth = GrowthFrom(5, 9);
  growth.Add(RecordAt(7, 10), 1);
  EXPECT_FALSE(growth.filled_hole);
  growth.Add(RecordAt(6, 10), 1);
  EXPECT_TRUE(growth.filled_hole);
  EXPECT_EQ(growth.acknowledged, 5);
  EXPECT_EQ(growth.highest, 9);
}

TEST(SessionGrowthTest, TimesAreThoseOfTheRecordsThatHaveOne) {
  SessionGrowth growth = GrowthFrom(0, 0);
  growth.Add({1, sensor::Withheld{"x"}}, 1);
  EXPECT_EQ(growth.first_time, std::nullopt);
  growth.Add(RecordAt(2, 30), 1);
  growth.Add(RecordAt(3, 20), 1);
  EXPECT_EQ(growth.first_time, 20);
  EXPECT_EQ(growth.last_time, 30);
  EXPECT_EQ(growth.counts, (RecordCounts{0, 2, 0, 0, 1}));
}

}  // namespace
}  // namespace enfilade::storage
