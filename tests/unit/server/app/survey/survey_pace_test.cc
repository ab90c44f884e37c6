// SPDX-License-Identifier: Apache-2.0
#include "server/app/survey/survey_pace.h"

#include "gtest/gtest.h"

namespace enfilade::server {
namespace {

const SurveyPace kPace{.growth = 0.5, .patience_s = 100.0};

storage::PendingSurvey WhileRobotsRecord(std::int64_t scans, double waiting_s) {
  return {.site = SiteId("s"), .scans = scans, .waiting_s = waiting_s, .under_way = true};
}

TEST(SurveyPace, SurveysWhatIsAtRestAtOnce) {
  storage::PendingSurvey pending = WhileRobotsRecord(1, 0.0);
  pending.under_way = false;
  EXPECT_TRUE(IsSurveyDue(pending, {.scans = 1000}, kPace));
}

TEST(SurveyPace, SurveysWhatWasNeverSurveyedAtOnce) { EXPECT_TRUE(IsSurveyDue(WhileRobotsRecord(1, 0.0), {}, kPace)); }

TEST(SurveyPace, WaitsUntilASiteUnderWayHasGrown) {
  EXPECT_FALSE(IsSurveyDue(WhileRobotsRecord(499, 10.0), {.scans = 1000, .age_s = 10.0}, kPace));
  EXPECT_TRUE(IsSurveyDue(WhileRobotsRecord(500, 10.0), {.scans = 1000, .age_s = 10.0}, kPace));
}

TEST(SurveyPace, WhatTheLastSurveyHasSeenIsNotNew) {
  EXPECT_FALSE(IsSurveyDue(WhileRobotsRecord(900, 10.0), {.scans = 1000, .pending = 800, .age_s = 10.0}, kPace));
  EXPECT_TRUE(IsSurveyDue(WhileRobotsRecord(1300, 10.0), {.scans = 1000, .pending = 800, .age_s = 10.0}, kPace));
}

TEST(SurveyPace, WaitsNoLongerThanItsPatience) {
  EXPECT_TRUE(IsSurveyDue(WhileRobotsRecord(1, 100.0), {.scans = 1000, .age_s = 200.0}, kPace));
  EXPECT_FALSE(IsSurveyDue(WhileRobotsRecord(1, 100.0), {.scans = 1000, .age_s = 50.0}, kPace));
}

}  // namespace
}  // namespace enfilade::server
