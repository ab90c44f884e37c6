// SPDX-License-Identifier: Apache-2.0
// Doors that lead to another level.
#include <cmath>
#include <optional>

#include "core/closure/decide.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/support/pose_matchers.h"
#include "tests/unit/core/closure/door_scenario.h"

namespace enfilade::closure {
namespace {

using ::enfilade::testing::PoseNear;

TEST(DecideLevels, ALiftLeadsToTheEnteredLevel) {
  DoorScenario scenario;
  scenario.Add("lift", {{"attic", {5, 5, 0}}, {"here", {10, 0, 0}}, {"room", {0, 0, 0}}});
  EXPECT_EQ(ActionOf<RecogniseLinkPoint>(scenario.Run().judgement).entered.map, MapId("room"));
  scenario.knowledge().report.entered_level = 1;
  const auto up = ActionOf<RecogniseLinkPoint>(scenario.Run().judgement);
  EXPECT_EQ(up.entered.map, MapId("attic"));
  EXPECT_THAT(up.entered.T_map_robot->pose, PoseNear(Pose2{7, 5, 0}, 1e-9, 1e-9));
  // No anchor on that level: the doors of a lift are above each other, and this one was not known.
  scenario.knowledge().report.entered_level = 7;
  EXPECT_EQ(ActionOf<StartMap>(scenario.Run().judgement).map.level, 7);
}

TEST(DecideLevels, TheHeadingOfANewLevelIsNoSurerThanTheRideToIt) {
  const auto yaw_variance = [](std::optional<int> level) {
    DoorScenario scenario;
    scenario.knowledge().report.entered_level = level;
    return ActionOf<StartMap>(scenario.Run().judgement).link_point.anchors.back().covariance(2, 2);
  };
  const DoorClosureOptions options;
  EXPECT_NEAR(yaw_variance(std::nullopt), std::pow(options.origin_yaw_sigma, 2), 1e-12);
  EXPECT_NEAR(yaw_variance(5), std::pow(options.origin_yaw_sigma, 2) + std::pow(options.ride_yaw_sigma, 2), 1e-12);
}

}  // namespace
}  // namespace enfilade::closure
