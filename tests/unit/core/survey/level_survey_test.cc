// SPDX-License-Identifier: Apache-2.0
#include "core/survey/level_survey.h"

#include "gtest/gtest.h"
#include "tests/unit/core/survey/drawn_level.h"

namespace enfilade::survey {
namespace {

TEST(PlaceOf, IsTheMotionFromTheSessionsPosesToTheSurveys) {
  const Pose2 place{3.0, -2.0, 2.5};
  const Drive drive = MakeDrive({{"s", "m", place, {{0.0, 0.0}, {4.0, 0.0}, {4.0, 3.0}}}});
  const std::optional<Pose2> found = PlaceOf(drive[0]);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->x, place.x, 1e-9);
  EXPECT_NEAR(found->y, place.y, 1e-9);
  EXPECT_NEAR(WrapAngle(found->yaw - place.yaw), 0.0, 1e-9);
}

TEST(PlaceOf, OneVisitSuffices) {
  const Pose2 place{-7.0, 1.0, -3.0};
  const Drive drive = MakeDrive({{"s", "m", place, {{1.0, 2.0}}}});
  const std::optional<Pose2> found = PlaceOf(drive[0]);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->x, place.x, 1e-9);
  EXPECT_NEAR(WrapAngle(found->yaw - place.yaw), 0.0, 1e-9);
}

TEST(PlaceOf, AveragesVisitsThatDisagree) {
  Drive drive = MakeDrive({{"s", "m", {}, {{0.0, 0.0}, {4.0, 0.0}}}});
  for (std::size_t i = 0; i < drive[0].visits.size(); ++i) {
    drive[0].visits[i].T_level_robot.y += i % 2 == 0 ? 0.1 : -0.1;
  }
  const std::optional<Pose2> found = PlaceOf(drive[0]);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->y, 0.0, 0.02);
  EXPECT_NEAR(found->yaw, 0.0, 0.01);
}

TEST(PlaceOf, IsUnsetWithoutVisits) { EXPECT_FALSE(PlaceOf({.id = SessionId("s"), .map = MapId("m")})); }

}  // namespace
}  // namespace enfilade::survey
