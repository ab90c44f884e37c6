// SPDX-License-Identifier: Apache-2.0
#include "core/prior/plan/planar.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <initializer_list>
#include <string>

#include "core/prior/plan/plan_check.h"

namespace enfilade::prior {
namespace {

struct Line {
  Eigen::Vector2d a, b;
};

PlanGraph PlanOf(std::initializer_list<Line> lines) {
  PlanGraph plan;
  for (const Line& line : lines) {
    const int from = static_cast<int>(plan.corners.size());
    plan.corners.push_back({line.a});
    plan.corners.push_back({line.b});
    plan.walls.push_back({.from = from, .to = from + 1});
  }
  return plan;
}

PlanGraph TwoRooms() {
  return PlanOf({{{0, 0}, {20, 0}}, {{20, 0}, {20, 10}}, {{20, 10}, {0, 10}}, {{0, 10}, {0, 0}}, {{12, 0}, {12, 10}}});
}

TEST(Planarise, JoinsEndsThatAreNear) {
  const PlanGraph plan = Planarise(PlanOf({{{0, 0}, {10, 0}}, {{10.2, 0.1}, {10, 8}}}), 0.5);
  EXPECT_EQ(plan.corners.size(), 3u);
  EXPECT_EQ(plan.walls.size(), 2u);
}

TEST(Planarise, CutsCrossingsAndTouches) {
  const PlanGraph cross = Planarise(PlanOf({{{0, 5}, {10, 5}}, {{4, 0}, {4, 9}}}), 0.1);
  EXPECT_EQ(cross.walls.size(), 4u);
  EXPECT_EQ(cross.corners.size(), 5u);
  EXPECT_TRUE(IsPlanar(cross));
  const PlanGraph touch = Planarise(PlanOf({{{0, 5}, {10, 5}}, {{4, 5.05}, {4, 9}}}), 0.1);
  EXPECT_EQ(touch.walls.size(), 3u);
  EXPECT_EQ(touch.corners.size(), 4u);
}

TEST(Planarise, MakesOneWallOfThoseThatLieOnEachOther) {
  const PlanGraph plan = Planarise(PlanOf({{{0, 0}, {10, 0}}, {{4, 0}, {14, 0}}}), 0.1);
  EXPECT_TRUE(IsPlanar(plan));
  EXPECT_EQ(plan.walls.size(), 3u);
  EXPECT_NEAR(WallLength(plan), 14, 1e-9);
}

TEST(Planarise, KeepsManyCrossingsPlanar) {
  PlanGraph plan;
  for (int i = 0; i < 40; ++i) {
    const double angle = 0.37 * i;
    const Eigen::Vector2d middle(10 * std::cos(1.7 * i), 10 * std::sin(2.3 * i));
    const Eigen::Vector2d along(30 * std::cos(angle), 30 * std::sin(angle));
    plan.corners.push_back({middle - along});
    plan.corners.push_back({middle + along});
    plan.walls.push_back({.from = 2 * i, .to = 2 * i + 1});
  }
  EXPECT_FALSE(IsPlanar(plan));
  EXPECT_TRUE(IsPlanar(Planarise(plan, 0.05)));
}

TEST(FindRooms, AreTheFacesButNotTheOutside) {
  const std::vector<PlanRoom> rooms = FindRooms(Planarise(TwoRooms(), 0.1), 0.5);
  ASSERT_EQ(rooms.size(), 2u);
  EXPECT_EQ(rooms[0].outline.size(), 4u);
}

TEST(FindRooms, EndAtClosedDoorsAndPassOpenWalls) {
  PlanGraph plan = PlanOf({{{0, 0}, {20, 0}},
                           {{20, 0}, {20, 10}},
                           {{20, 10}, {0, 10}},
                           {{0, 10}, {0, 0}},
                           {{12, 0}, {12, 4}},
                           {{12, 6}, {12, 10}}});
  EXPECT_EQ(FindRooms(Planarise(plan, 0.1), 0.5).size(), 1u);
  plan.doors = {{.from = {12, 4}, .to = {12, 6}}};
  EXPECT_EQ(FindRooms(Planarise(plan, 0.1), 0.5).size(), 2u);
}

TEST(CheckPlan, NamesTheCountOfTooFewWalls) {
  const absl::Status status = CheckPlan(Planarise(TwoRooms(), 0.1));
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(status.message(), "7 walls, 8 needed");
}

TEST(CheckPlan, RefusesMoreThanAMillionWalls) {
  PlanGraph plan;
  plan.corners = {{{0, 0}}, {{1, 0}}};
  plan.walls.assign(kMostWalls + 1, {.from = 0, .to = 1});
  const absl::Status status = CheckPlan(plan);
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(status.message()), ::testing::HasSubstr("1000001 walls"));
}

}  // namespace
}  // namespace enfilade::prior
