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

double YawVariance(const PoseWithCovariance& pose) { return pose.covariance(2, 2); }

// By how much the ride makes the heading in the robot's map less certain, rad^2.
double RideVariance(std::optional<int> entered_level, std::optional<TimeNs> level_time) {
  DoorScenario scenario;
  DoorKnowledge& knowledge = scenario.knowledge();
  knowledge.report.entered_level = entered_level;
  knowledge.report.level_time = level_time;
  const double before = YawVariance(*knowledge.T_map_robot);
  AddRide(knowledge);
  EXPECT_NEAR(YawVariance(*knowledge.T_map_door), YawVariance(*knowledge.T_map_robot), 1e-12);
  return YawVariance(*knowledge.T_map_robot) - before;
}

TEST(DecideLevels, ARideShowsTheHeadingLessSurely) {
  const double ride = std::pow(DoorClosureOptions().ride_yaw_sigma, 2);
  EXPECT_NEAR(RideVariance(std::nullopt, std::nullopt), 0.0, 1e-12);
  EXPECT_NEAR(RideVariance(0, std::nullopt), 0.0, 1e-12) << "the level that the map is on";
  EXPECT_NEAR(RideVariance(1, std::nullopt), ride, 1e-12);
  EXPECT_NEAR(RideVariance(0, TimeNs{9'000'000'000}), ride, 1e-12) << "back to the cabin's own level";
}

TEST(DecideLevels, ALevelIsNoSurerThanTheRideToIt) {
  DoorScenario scenario;
  scenario.Add("lift", {{"attic", {5, 5, 0}}, {"here", {10, 0, 0}}});
  scenario.knowledge().report.entered_level = 1;
  AddRide(scenario.knowledge());
  const double ride = std::pow(scenario.knowledge().options.ride_yaw_sigma, 2);
  const auto known = ActionOf<RecogniseLinkPoint>(scenario.Run().judgement);
  EXPECT_GT(YawVariance(*known.entered.T_map_robot), ride);
  scenario.knowledge().report.entered_level = 7;
  const auto begun = ActionOf<StartMap>(scenario.Run().judgement);
  EXPECT_GT(begun.link_point.anchors.front().covariance(2, 2), ride);
}

}  // namespace
}  // namespace enfilade::closure
