// SPDX-License-Identifier: Apache-2.0
#include "client/sources/formats/survey.h"

#include <gtest/gtest.h>

#include "tests/support/status_assertions.h"
#include "tests/unit/client/sources/log_files.h"

namespace enfilade::sources {
namespace {

using sources::RangeSurvey;
using testing::AllOf;
using testing::FlaserLine;
using ::testing::HasSubstr;
using testing::LogFiles;
using testing::ReadAll;
using testing::ReadLog;

ReadLog ReadTimes(const std::vector<std::pair<std::string, std::string>>& times) {
  const LogFiles files;
  std::string text;
  for (const auto& [ipc, logger] : times) text += FlaserLine({"1", "2", "3"}, ipc, logger);
  return ReadAll(files.Write("times.log", text));
}

std::vector<TimeNs> ScanTimes(const ReadLog& log) {
  std::vector<TimeNs> times;
  for (const sensor::LaserScan& scan : AllOf<sensor::LaserScan>(log)) times.push_back(scan.time);
  return times;
}

TEST(TimeSurvey, PrefersTheMessagesTime) {
  const ReadLog log = ReadTimes({{"100.5", "1"}, {"101.5", "2"}});
  EXPECT_EQ(ScanTimes(log), (std::vector<TimeNs>{100'500'000'000, 101'500'000'000}));
  EXPECT_FALSE(log.facts.synthetic_times);
}

TEST(TimeSurvey, TakesTheLoggersTimeWhereTheMessagesIsConstant) {
  const ReadLog log = ReadTimes({{"0", "1"}, {"0", "2"}, {"0", "3.25"}});
  EXPECT_EQ(ScanTimes(log).back(), 3'250'000'000);
  EXPECT_EQ(log.facts.times, "logger_timestamp");
}

TEST(TimeSurvey, ShiftsNegativeTimesToZero) {
  const ReadLog log = ReadTimes({{"-3.02142", "1"}, {"-1", "2"}, {"2", "3"}});
  EXPECT_OK(log.status);
  EXPECT_EQ(ScanTimes(log), (std::vector<TimeNs>{0, 2'021'420'000, 5'021'420'000}));
  EXPECT_THAT(log.facts.times, HasSubstr("shifted by 3.02142 s"));
}

TEST(TimeSurvey, FallsBackToLineOrderWhereNoTimeIsUsable) {
  const ReadLog equal = ReadTimes({{"0", "0"}, {"0", "0"}, {"0", "0"}});
  EXPECT_TRUE(equal.facts.synthetic_times);
  EXPECT_EQ(ScanTimes(equal), (std::vector<TimeNs>{0, 500'000'000, 1'000'000'000}));
  const ReadLog garbage = ReadTimes({{"5", "9"}, {"1", "8"}, {"4e-86", "7"}, {"-3", "6"}});
  EXPECT_TRUE(garbage.facts.synthetic_times);
}

TEST(TimeSurvey, DeliversSingleReversalsAsTheyAreAndCountsThem) {
  std::vector<std::pair<std::string, std::string>> times;
  for (int i = 0; i < 20; ++i) times.emplace_back(std::to_string(i == 10 ? 3 : i), "0");
  const ReadLog log = ReadTimes(times);
  EXPECT_FALSE(log.facts.synthetic_times);
  EXPECT_EQ(log.counts.scans_back_in_time, 1);
  EXPECT_EQ(ScanTimes(log)[10], 3'000'000'000);
}

float ChosenOf(const std::vector<float>& ranges, double declared = 0.0) {
  RangeSurvey survey;
  survey.Add(ranges);
  return survey.Choose(declared);
}

TEST(RangeSurvey, KnowsTheScannersNoEchoCodes) {
  EXPECT_EQ(ChosenOf({1.0F, 40.0F, 81.87F}), 81.83F);
  EXPECT_EQ(ChosenOf({1.0F, 20.0F, 32.767F}), 32.759F);
  EXPECT_NE(ChosenOf({1.0F, 32.767F, 60.0F}), 32.759F) << "a scanner that measures farther";
}

TEST(RangeSurvey, FindsASaturatedReadingByItsRepetition) {
  std::vector<float> ranges(500, 50.0F);
  for (int i = 0; i < 500; ++i) ranges.push_back(0.09F * static_cast<float>(i));
  EXPECT_EQ(ChosenOf(ranges), 50.0F);
}

TEST(RangeSurvey, TakesEveryReadingForAHitWhereNoneRepeats) {
  std::vector<float> ranges;
  for (int i = 0; i < 5000; ++i) ranges.push_back(0.005F * static_cast<float>(i));
  EXPECT_GT(ChosenOf(ranges), ranges.back());
}

TEST(RangeSurvey, DeclaredReachCountsUnlessReadingsPileUpBelowIt) {
  EXPECT_FLOAT_EQ(ChosenOf({1.0F, 90.0F}, 80.99), 80.99F);
  std::vector<float> ranges(500, 50.0F);
  EXPECT_EQ(ChosenOf(ranges, 80.99), 50.0F);
}

}  // namespace
}  // namespace enfilade::sources
