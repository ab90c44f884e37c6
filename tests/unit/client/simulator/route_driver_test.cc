// SPDX-License-Identifier: Apache-2.0
#include "client/simulator/route_driver.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "client/simulator/campus/campus_yaml.h"
#include "fmt/format.h"
#include "tests/support/pose_matchers.h"
#include "tests/support/status_assertions.h"

namespace enfilade::simulator {
namespace {

using ::testing::HasSubstr;

constexpr double kStep = 0.05;  // s

struct DrivenRoute {
  std::vector<Pose2> poses;
  std::vector<RouteDriver::Step> steps;
  std::vector<std::string> levels;
  absl::Status status;
};

// Drives the first robot of a campus to the end of its route.
DrivenRoute DriveRoute(const std::string& yaml, const MotionLimits& limits = {}) {
  DrivenRoute driven;
  absl::StatusOr<Campus> campus = ParseCampus(yaml);
  EXPECT_OK(campus.status());
  const auto world = std::make_shared<const World>(*std::move(campus));
  RouteDriver driver(world, world->campus().robots[0], limits, kStep);
  driven.poses.push_back(driver.T_campus_robot());
  for (int i = 0; i < 100'000; ++i) {
    const absl::StatusOr<std::optional<RouteDriver::Step>> step = driver.Next();
    driven.status = step.status();
    if (!step.ok() || !step->has_value()) return driven;
    driven.steps.push_back(**step);
    driven.poses.push_back(driver.T_campus_robot());
    driven.levels.push_back(driver.level());
  }
  ADD_FAILURE() << "the route does not end";
  return driven;
}

std::string Yard(const std::string& robot) {
  return "areas: [{id: yard, kind: outdoor, rect: [-20, -20, 40, 40]}]\nrobots: [{id: r, " + robot + "}]\n";
}

TEST(RouteDriver, PassesEveryPointWithinItsLimits) {
  const MotionLimits limits{0.8, 1.1};
  const std::vector<Eigen::Vector2d> points = {{0, 0}, {5, 0}, {5, 5}, {-3, 5}, {-3, -4}};
  std::string route;
  for (const Eigen::Vector2d& p : points) route += fmt::format("[{}, {}], ", p.x(), p.y());
  const DrivenRoute driven = DriveRoute(Yard("route: [" + route + "]"), limits);
  ASSERT_OK(driven.status);
  std::size_t next = 0;
  for (const Pose2& pose : driven.poses) {
    if (next < points.size() && (pose.translation() - points[next]).norm() <= 0.16) ++next;
  }
  EXPECT_EQ(next, points.size()) << "the points are passed in their order";
  Pose2 pose = driven.poses[0];
  for (std::size_t i = 0; i < driven.steps.size(); ++i) {
    EXPECT_LE(driven.steps[i].forward, limits.speed * kStep + 1e-12);
    EXPECT_GE(driven.steps[i].forward, 0.0);
    EXPECT_LE(std::abs(driven.steps[i].turn), limits.turn_rate * kStep + 1e-12);
    pose = pose * ArcStep(driven.steps[i].forward, driven.steps[i].turn);
    ASSERT_THAT(pose, testing::PoseNear(driven.poses[i + 1], 1e-9, 1e-9)) << "the steps are the motion";
  }
}

TEST(RouteDriver, StartsHeadingForItsFirstGoal) {
  EXPECT_NEAR(DriveRoute(Yard("route: [[0, 0], [3, 3]]")).poses[0].yaw, M_PI / 4.0, 1e-12);
  EXPECT_NEAR(DriveRoute(Yard("route: [[0, 0], {wait: 1}, [0, -2]]")).poses[0].yaw, -M_PI / 2.0, 1e-12);
  EXPECT_NEAR(DriveRoute(Yard("route: [[0, 0], {turn_to_deg: 30}, [0, -2]]")).poses[0].yaw, M_PI / 6.0, 1e-12);
}

TEST(RouteDriver, WaitsAndTurnsOnTheSpot) {
  const DrivenRoute driven = DriveRoute(Yard("route: [[0, 0], {wait: 2}, {turn_to_deg: 180}, {wait: 1}]"));
  ASSERT_OK(driven.status);
  EXPECT_NEAR(driven.poses.back().translation().norm(), 0.0, 1e-12);
  EXPECT_NEAR(std::abs(driven.poses.back().yaw), M_PI, 0.03);
  EXPECT_NEAR(static_cast<double>(driven.steps.size()) * kStep, 3.0, 0.2) << "it already faces 180 degrees";
}

TEST(RouteDriver, RepeatsItsRouteForEveryLap) {
  const auto length = [](const std::string& robot) {
    double sum = 0.0;
    const DrivenRoute driven = DriveRoute(Yard(robot));
    EXPECT_OK(driven.status);
    for (const RouteDriver::Step& step : driven.steps) sum += step.forward;
    return sum;
  };
  const std::string route = "route: [[0, 0], [10, 0]]";
  EXPECT_NEAR(length(route), 10.0, 0.5);
  EXPECT_NEAR(length("returns: true, " + route), 20.0, 1.0);
  EXPECT_NEAR(length("laps: 3, " + route), 50.0, 2.5) << "back to the start between laps";
  EXPECT_NEAR(length("laps: 3, returns: true, " + route), 60.0, 3.0);
  const std::string around = "back: [[10, 5], [0, 5]], " + route;  // 20 m
  EXPECT_NEAR(length(around), 10.0, 0.5) << "the way back is for further laps";
  EXPECT_NEAR(length("laps: 2, " + around), 40.0, 3.0);
  EXPECT_NEAR(length("returns: true, " + around), 30.0, 2.0);
}

TEST(RouteDriver, DrivesAtTheSpeedOfTheRobot) {
  const DrivenRoute driven = DriveRoute(Yard("speed: 0.25, route: [[0, 0], [5, 0]]"), {2.0, 1.0});
  ASSERT_OK(driven.status);
  EXPECT_NEAR(static_cast<double>(driven.steps.size()) * kStep * 0.25, 5.0, 0.3);
}

constexpr const char* kRoomsWithADoor = R"(
areas:
  - {id: a, rect: [0, 0, 4, 4], doors: [{id: d, side: east, at: 2, width: 1, STATE}]}
  - {id: b, rect: [4, 0, 4, 4]}
robots: [{id: r, route: [[1, 1], {door: d}, [6, 3], {door: d}, [1, 3]]}]
)";

std::string TwoRoomsWith(const std::string& state) {
  std::string yaml = kRoomsWithADoor;
  return yaml.replace(yaml.find("STATE"), 5, state);
}

TEST(RouteDriver, GoesStraightThroughDoorsBothWays) {
  const DrivenRoute driven = DriveRoute(TwoRoomsWith("state: open"));
  ASSERT_OK(driven.status);
  int crossings = 0;
  for (std::size_t i = 1; i < driven.poses.size(); ++i) {
    const bool before = driven.poses[i - 1].x < 4.0;
    const bool after = driven.poses[i].x < 4.0;
    if (before == after) continue;
    ++crossings;
    EXPECT_NEAR(driven.poses[i].y, 2.0, 0.2);
    EXPECT_LT(std::abs(std::sin(driven.poses[i].yaw)), 0.2) << "straight";
  }
  EXPECT_EQ(crossings, 2);
}

TEST(RouteDriver, StopsAtObstaclesWithTheirPlace) {
  for (const char* state : {"state: closed", "state: glass"}) {
    const DrivenRoute driven = DriveRoute(TwoRoomsWith(state));
    EXPECT_STATUS(driven.status, absl::StatusCode::kFailedPrecondition,
                  HasSubstr("robot r: the route runs into a wall at (4."))
        << state;
  }
  EXPECT_STATUS(DriveRoute(Yard("route: [[0, 0], [5, 0]]") + "boxes: [{rect: [2, -1, 1, 2], height: 0.3}]\n").status,
                absl::StatusCode::kFailedPrecondition, HasSubstr("into a wall at (2."));
  EXPECT_OK(
      DriveRoute(Yard("route: [[0, 0], [5, 0]]") + "boxes: [{rect: [2, -1, 1, 2], bottom: 0.6, height: 0.9}]\n").status)
      << "it drives under a table top";
}

TEST(RouteDriver, RidesALiftToItsLevel) {
  const std::string yaml = R"(
levels: {ground: 0, first: 3}
lifts: [{id: lift, rect: [4, 0, 2, 2], side: west, levels: [ground, first]}]
areas: [{id: a, rect: [0, -2, 4, 6], level: ground}, {id: b, rect: [0, -2, 4, 6], level: first}]
robots: [{id: r, route: [[1, 1], {door: lift/ground}, {lift: lift, to: first, seconds: 4}, {door: lift/first}, [1, 1]]}]
)";
  const DrivenRoute driven = DriveRoute(yaml);
  ASSERT_OK(driven.status);
  EXPECT_EQ(driven.levels.front(), "ground");
  EXPECT_EQ(driven.levels.back(), "first");
  int changes = 0;
  for (std::size_t i = 1; i < driven.levels.size(); ++i) {
    if (driven.levels[i] == driven.levels[i - 1]) continue;
    ++changes;
    EXPECT_GT(driven.poses[i].x, 4.0) << "inside the cabin";
  }
  EXPECT_EQ(changes, 1);
  const std::string outside =
      "levels: {ground: 0, first: 3}\nlifts: [{id: lift, rect: [4, 0, 2, 2], side: west, levels: [ground, first]}]\n"
      "robots: [{id: r, route: [[1, 1], {lift: lift, to: first}]}]\n";
  EXPECT_STATUS(DriveRoute(outside).status, absl::StatusCode::kFailedPrecondition, HasSubstr("is not in it"));
}

}  // namespace
}  // namespace enfilade::simulator
