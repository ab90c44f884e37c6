// SPDX-License-Identifier: Apache-2.0
#include "server/app/survey/survey_schedule.h"

#include <chrono>

#include "gtest/gtest.h"

namespace enfilade::server {
namespace {

using std::chrono::seconds;

const SiteId kSite("campus");

class SurveyScheduleTest : public ::testing::Test {
 protected:
  static storage::PendingSurvey Recording(std::int64_t sessions) { return {kSite, sessions, false}; }
  static storage::PendingSurvey Ended(std::int64_t sessions) { return {kSite, sessions, true}; }
  static storage::PendingSurvey Lagging(std::int64_t sessions) { return {kSite, sessions, false, true}; }

  SurveySchedule schedule_{{.growth = 0.5, .interval = seconds(300)}};
  const SurveySchedule::Clock::time_point start_{seconds(1000)};
};

TEST_F(SurveyScheduleTest, ASiteOfWhichNothingIsKnownIsDue) { EXPECT_TRUE(schedule_.IsDue(Recording(1), start_)); }

TEST_F(SurveyScheduleTest, WhileRobotsRecordASiteMustHaveGrown) {
  schedule_.CountSurvey(kSite, 10, start_);
  EXPECT_FALSE(schedule_.IsDue(Recording(4), start_ + seconds(20)));
  EXPECT_TRUE(schedule_.IsDue(Recording(5), start_ + seconds(20)));
}

TEST_F(SurveyScheduleTest, ASmallSiteIsDueAfterEachSession) {
  schedule_.CountSurvey(kSite, 2, start_);
  EXPECT_TRUE(schedule_.IsDue(Recording(1), start_));
}

TEST_F(SurveyScheduleTest, OnceADriveHasEndedItsSiteIsDue) {
  schedule_.CountSurvey(kSite, 1000, start_);
  EXPECT_TRUE(schedule_.IsDue(Ended(1), start_));
}

TEST_F(SurveyScheduleTest, ASiteWaitsForTheIntervalAtMost) {
  schedule_.CountSurvey(kSite, 1000, start_);
  EXPECT_FALSE(schedule_.IsDue(Recording(1), start_ + seconds(299)));
  EXPECT_TRUE(schedule_.IsDue(Recording(1), start_ + seconds(300)));
}

TEST_F(SurveyScheduleTest, WhileMappingLagsASiteWaitsForTheInterval) {
  schedule_.CountSurvey(kSite, 10, start_);
  EXPECT_TRUE(schedule_.IsDue(Recording(100), start_ + seconds(299)));
  EXPECT_FALSE(schedule_.IsDue(Lagging(100), start_ + seconds(299)));
  EXPECT_TRUE(schedule_.IsDue(Lagging(1), start_ + seconds(300)));
  EXPECT_TRUE(schedule_.IsDue({kSite, 1, true, true}, start_)) << "another robot's drive has ended";
}

TEST_F(SurveyScheduleTest, AfterAFailureASiteWaitsForAMoment) {
  schedule_.CountSurvey(kSite, 10, start_);
  EXPECT_EQ(schedule_.CountFailure(kSite, start_), 1);
  EXPECT_EQ(schedule_.CountFailure(kSite, start_), 2);
  EXPECT_FALSE(schedule_.IsDue(Ended(1), start_ + seconds(1)));
  EXPECT_TRUE(schedule_.IsDue(Recording(1), start_ + seconds(2))) << "it was due when the survey failed";
  schedule_.CountSurvey(kSite, 10, start_ + seconds(2));
  EXPECT_EQ(schedule_.CountFailure(kSite, start_ + seconds(3)), 1) << "failures in a row";
}

TEST_F(SurveyScheduleTest, WhatFailsForEverIsTriedOnceAMinute) {
  for (int i = 1; i <= 10; ++i) schedule_.CountFailure(kSite, start_);
  EXPECT_TRUE(schedule_.IsDue(Ended(1), start_ + seconds(2)));
  schedule_.CountFailure(kSite, start_);
  EXPECT_FALSE(schedule_.IsDue(Ended(1), start_ + seconds(3)));
  EXPECT_TRUE(schedule_.IsDue(Ended(1), start_ + seconds(4)));
  for (int i = 0; i < 100; ++i) schedule_.CountFailure(kSite, start_);
  EXPECT_FALSE(schedule_.IsDue(Ended(1), start_ + seconds(60)));
  EXPECT_TRUE(schedule_.IsDue(Ended(1), start_ + seconds(64)));
}

TEST_F(SurveyScheduleTest, SitesDoNotWaitForEachOther) {
  schedule_.CountSurvey(SiteId("other"), 1000, start_);
  schedule_.CountFailure(SiteId("other"), start_);
  EXPECT_TRUE(schedule_.IsDue(Recording(1), start_));
}

}  // namespace
}  // namespace enfilade::server
