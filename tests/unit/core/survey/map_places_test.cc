// SPDX-License-Identifier: Apache-2.0
#include "core/survey/map_places.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/support/pose_matchers.h"
#include "tests/unit/core/survey/drawn_level.h"

namespace enfilade::survey {
namespace {

using ::enfilade::testing::PoseNear;
using ::testing::SizeIs;

TEST(MapPlaces, AMapIsWhereMostOfWhatWasDrivenInItHasIt) {
  const LevelSurvey survey = CorridorDrivenThreeTimes({0.3, -0.2, 0.0});
  const auto places = PlaceMaps(survey, {});
  EXPECT_THAT(places.at(MapId("a")), PoseNear(Pose2{}, 1e-9, 1e-9)) << "by s2 and s3, though s1 is the longest one";
}

// The survey that put s1 there knew less of how the drive bends.
TEST(MapPlaces, ASessionGoesToWhereTheSurveyHasIt) {
  for (const Pose2& error : {Pose2{0.15, 0.0, 0.0}, Pose2{0.0, -0.15, 0.0}, Pose2{0.0, 0.0, 0.05}}) {
    const LevelSurvey survey = CorridorDrivenThreeTimes(error);
    const rearrange::Rearrangement change = Arrange(survey);
    EXPECT_TRUE(rearrange::Validate(change).ok());
    ASSERT_THAT(change.moves, SizeIs(1));
    EXPECT_EQ(change.moves[0].session, SessionId("s1"));
    EXPECT_EQ(change.moves[0].to, MapId("a"));
    EXPECT_THAT(change.moves[0].T_to_from, PoseNear(error, 1e-9, 1e-9));
    EXPECT_TRUE(Arrange(After(survey, change)).empty());
  }
}

TEST(MapPlaces, ASessionThatIsHardlyOutOfPlaceStays) {
  EXPECT_TRUE(Arrange(CorridorDrivenThreeTimes({0.05, 0.05, 0.0})).empty());
  EXPECT_TRUE(Arrange(CorridorDrivenThreeTimes({0.0, 0.0, 0.01})).empty());
}

// What turns about the map's origin, far away, moves the session, and what turns about the session does not.
TEST(MapPlaces, WhatCountsIsWhereTheSessionIs) {
  SurveyOptions options;
  const LevelSurvey survey = CorridorDrivenThreeTimes({});
  const SurveyedSession& session = survey.drives[0][0];
  const Pose2 about_session = Pose2{4.0, 4.0, 0.03} * Pose2{-4.0, -4.0, 0.0};
  EXPECT_GT(about_session.translation().norm(), options.apart);
  EXPECT_FALSE(IsOutOfPlace(session, about_session, options));
  EXPECT_TRUE(IsOutOfPlace(session, {0.0, 0.0, 0.03}, options));
  EXPECT_FALSE(IsOutOfPlace({}, {1.0, 0.0, 0.0}, options)) << "nothing says where it is";
}

}  // namespace
}  // namespace enfilade::survey
