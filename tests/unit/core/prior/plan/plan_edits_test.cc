// SPDX-License-Identifier: Apache-2.0
#include "core/prior/plan/plan_edits.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>
#include <utility>

#include "core/prior/plan/planar.h"
#include "core/prior/plan/room_names.h"
#include "tests/support/plans/drawn_building.h"
#include "tests/support/status_assertions.h"

namespace enfilade::prior {
namespace {

using Eigen::Vector2d;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

void Draw(PlanGraph& plan, const Vector2d& a, const Vector2d& b, double thickness = 0) {
  const int from = static_cast<int>(plan.corners.size());
  plan.corners.push_back({a});
  plan.corners.push_back({b});
  plan.walls.push_back({.from = from, .to = from + 1, .thickness = thickness});
}

// As it is stored: planar, with rooms. Two rooms side by side, the right one has a name, and a third below them; a
// metre has 20 units.
//
//   0     100    200
//   +------+------+ 0
//   |      |      |
//   +--..--+------+ 100     a door in the wall below the left room, from 40 to 60
//   |             |
//   +-------------+ 200
PlanGraph ThreeRooms() {
  PlanGraph plan;
  for (const auto& [a, b] : std::initializer_list<std::pair<Vector2d, Vector2d>>{{{0, 0}, {100, 0}},
                                                                                 {{100, 0}, {200, 0}},
                                                                                 {{200, 0}, {200, 100}},
                                                                                 {{200, 100}, {200, 200}},
                                                                                 {{200, 200}, {0, 200}},
                                                                                 {{0, 200}, {0, 100}},
                                                                                 {{0, 100}, {0, 0}},
                                                                                 {{100, 0}, {100, 100}},
                                                                                 {{0, 100}, {40, 100}},
                                                                                 {{60, 100}, {100, 100}},
                                                                                 {{100, 100}, {200, 100}}}) {
    Draw(plan, a, b, 3);
  }
  plan.metres_per_unit = 0.05;
  plan.doors = {{.from = {40, 100}, .to = {60, 100}, .confidence = 0.7}};
  plan = Planarise(plan, 0.5);
  plan.rooms = FindRooms(plan, NarrowestRoom(plan));
  for (PlanRoom& room : plan.rooms) {
    if (InsideOf(room.outline).x() > 100 && InsideOf(room.outline).y() < 100) room.name = "Right";
  }
  return plan;
}

const PlanWall* WallBetween(const PlanGraph& plan, const Vector2d& a, const Vector2d& b) {
  for (const PlanWall& wall : plan.walls) {
    const Vector2d &from = plan.corners[wall.from].point, &to = plan.corners[wall.to].point;
    if ((from == a && to == b) || (from == b && to == a)) return &wall;
  }
  return nullptr;
}

void Remove(PlanGraph& plan, const Vector2d& a, const Vector2d& b) {
  const PlanWall* wall = WallBetween(plan, a, b);
  ASSERT_NE(wall, nullptr);
  plan.walls.erase(plan.walls.begin() + (wall - plan.walls.data()));
}

std::string NameAt(const PlanGraph& plan, const Vector2d& place) {
  double nearest = 1e9;
  std::string name;
  for (const PlanRoom& room : plan.rooms) {
    const double distance = (InsideOf(room.outline) - place).norm();
    if (distance < nearest) nearest = distance, name = room.name;
  }
  return name;
}

bool IsSame(const PlanGraph& a, const PlanGraph& b) {
  if (a.corners.size() != b.corners.size() || a.walls.size() != b.walls.size()) return false;
  return std::all_of(a.walls.begin(), a.walls.end(), [&](const PlanWall& wall) {
    const PlanWall* other = WallBetween(b, a.corners[wall.from].point, a.corners[wall.to].point);
    return other && other->thickness == wall.thickness && other->confidence == wall.confidence;
  });
}

TEST(ApplyEdits, WhatIsDrawnAsItWasChangesNothing) {
  for (const PlanGraph& before : {ThreeRooms(), DrawnBuilding()}) {
    PlanGraph drawn = before;
    // As a program writes it that rounds, and loses all but the lines.
    for (PlanCorner& corner : drawn.corners) corner.point += Vector2d(3e-5, -2e-5);
    std::reverse(drawn.walls.begin(), drawn.walls.end());
    for (PlanWall& wall : drawn.walls) std::swap(wall.from, wall.to);
    drawn.metres_per_unit.reset();
    ASSERT_OK_AND_ASSIGN(const EditedPlan edited, ApplyEdits(before, drawn));
    EXPECT_FALSE(edited.changes.Any()) << Describe(edited.changes);
    EXPECT_THAT(edited.warnings, IsEmpty());
    EXPECT_TRUE(IsSame(edited.plan, before));
    EXPECT_EQ(edited.plan.metres_per_unit, before.metres_per_unit);
    EXPECT_EQ(edited.plan.doors.size(), before.doors.size());
  }
}

TEST(ApplyEdits, ANewWallIsJoinedAndDividesARoom) {
  const PlanGraph before = ThreeRooms();
  PlanGraph drawn = before;
  Draw(drawn, {100.4, 99.7}, {99.8, 200.3}, 4);  // from a corner to a wall, both missed by a little
  ASSERT_OK_AND_ASSIGN(const EditedPlan edited, ApplyEdits(before, drawn));
  EXPECT_EQ(Describe(edited.changes), "1 wall added");
  EXPECT_THAT(edited.warnings, IsEmpty());
  EXPECT_TRUE(IsPlanar(edited.plan));
  const PlanWall* wall = WallBetween(edited.plan, {100, 100}, {99.8, 200});
  ASSERT_NE(wall, nullptr);
  EXPECT_EQ(wall->thickness, 4);
  EXPECT_EQ(edited.plan.walls.size(), before.walls.size() + 2) << "the outer wall has two parts now";
  EXPECT_EQ(edited.plan.rooms.size(), 4U);
  EXPECT_EQ(NameAt(edited.plan, {150, 50}), "Right");
  for (const PlanWall& one : before.walls) {
    const Vector2d &from = before.corners[one.from].point, &to = before.corners[one.to].point;
    if (from.y() == 200 && to.y() == 200) continue;
    EXPECT_NE(WallBetween(edited.plan, from, to), nullptr) << "what is not edited stays where it is";
  }
}

TEST(ApplyEdits, WallsThatCrossAreCut) {
  const PlanGraph before = ThreeRooms();
  PlanGraph drawn = before;
  Draw(drawn, {20, 20}, {180, 60});
  Draw(drawn, {150, 10}, {150, 90});
  ASSERT_OK_AND_ASSIGN(const EditedPlan edited, ApplyEdits(before, drawn));
  EXPECT_EQ(edited.changes.walls_added, 2);
  EXPECT_TRUE(IsPlanar(edited.plan));
  EXPECT_NE(WallBetween(edited.plan, {100, 40}, {100, 0}), nullptr);
  EXPECT_NE(WallBetween(edited.plan, {100, 40}, {20, 20}), nullptr);
}

TEST(ApplyEdits, RemovingAWallJoinsTheRooms) {
  const PlanGraph before = ThreeRooms();
  PlanGraph drawn = before;
  Remove(drawn, {100, 0}, {100, 100});
  ASSERT_OK_AND_ASSIGN(const EditedPlan edited, ApplyEdits(before, drawn));
  EXPECT_EQ(Describe(edited.changes), "1 wall removed");
  EXPECT_EQ(edited.plan.rooms.size(), 2U);
  EXPECT_EQ(NameAt(edited.plan, {100, 50}), "Right") << "the only name of both";
}

// Both outlines change.
TEST(ApplyEdits, AMovedCornerTakesItsWallsAlong) {
  const PlanGraph before = ThreeRooms();
  PlanGraph drawn = before;
  for (PlanCorner& corner : drawn.corners) {
    if (corner.point == Vector2d(200, 200)) corner.point = {230, 220};
  }
  ASSERT_OK_AND_ASSIGN(const EditedPlan edited, ApplyEdits(before, drawn));
  EXPECT_EQ(Describe(edited.changes), "2 walls added, 2 removed");
  EXPECT_NE(WallBetween(edited.plan, {230, 220}, {0, 200}), nullptr);
  EXPECT_NE(WallBetween(edited.plan, {230, 220}, {200, 100}), nullptr);
  EXPECT_EQ(edited.plan.walls.size(), before.walls.size());
  EXPECT_EQ(edited.plan.rooms.size(), 3U);
}

TEST(ApplyEdits, ADoorOnAWallMakesAGap) {
  const PlanGraph before = ThreeRooms();
  PlanGraph drawn = before;
  drawn.doors.push_back({.from = {100.3, 30}, .to = {99.8, 50}});
  ASSERT_OK_AND_ASSIGN(const EditedPlan edited, ApplyEdits(before, drawn));
  EXPECT_EQ(Describe(edited.changes), "1 door added");
  ASSERT_EQ(edited.plan.doors.size(), 2U);
  EXPECT_EQ(edited.plan.doors[0].confidence, 0.7);
  EXPECT_EQ(edited.plan.doors[1].from, Vector2d(100, 30));
  EXPECT_EQ(edited.plan.doors[1].to, Vector2d(100, 50));
  EXPECT_NE(WallBetween(edited.plan, {100, 0}, {100, 30}), nullptr);
  EXPECT_NE(WallBetween(edited.plan, {100, 50}, {100, 100}), nullptr);
  EXPECT_EQ(WallBetween(edited.plan, {100, 30}, {100, 50}), nullptr);
  EXPECT_EQ(edited.plan.rooms.size(), 3U) << "doors close rooms";
  // Without it the gap stays, and the rooms are one.
  PlanGraph without = edited.plan;
  without.doors.pop_back();
  ASSERT_OK_AND_ASSIGN(const EditedPlan again, ApplyEdits(edited.plan, without));
  EXPECT_EQ(Describe(again.changes), "1 door removed");
  EXPECT_EQ(again.plan.rooms.size(), 2U);
}

TEST(ApplyEdits, ADoorFillsAGap) {
  PlanGraph before = ThreeRooms();
  before.doors.clear();
  PlanGraph drawn = before;
  drawn.doors.push_back({.from = {39.5, 100.2}, .to = {60.4, 99.9}});
  ASSERT_OK_AND_ASSIGN(const EditedPlan edited, ApplyEdits(before, drawn));
  EXPECT_EQ(edited.plan.doors.front().from, Vector2d(40, 100));
  EXPECT_EQ(edited.plan.doors.front().to, Vector2d(60, 100));
  EXPECT_TRUE(IsSame(edited.plan, before)) << "the walls stay";
}

TEST(ApplyEdits, TakesScaleThicknessNamesAndShafts) {
  const PlanGraph before = ThreeRooms();
  PlanGraph drawn = before;
  drawn.metres_per_unit = 0.06;
  ASSERT_OK_AND_ASSIGN(EditedPlan edited, ApplyEdits(before, drawn));
  EXPECT_EQ(Describe(edited.changes), "another scale");
  EXPECT_EQ(edited.plan.metres_per_unit, 0.06);
  EXPECT_TRUE(IsSame(edited.plan, before));
  drawn = before;
  drawn.walls[2].thickness = 7;
  ASSERT_OK_AND_ASSIGN(edited, ApplyEdits(before, drawn));
  EXPECT_EQ(Describe(edited.changes), "1 wall changed");
  EXPECT_EQ(std::count_if(edited.plan.walls.begin(), edited.plan.walls.end(),
                          [](const PlanWall& wall) { return wall.thickness == 7; }),
            1);
  drawn = before;
  drawn.rooms[0].name = "Hall";
  ASSERT_OK_AND_ASSIGN(edited, ApplyEdits(before, drawn));
  EXPECT_EQ(Describe(edited.changes), "other rooms or shafts");
  EXPECT_EQ(edited.plan.rooms[0].name, "Hall");
  drawn = before;
  drawn.shafts.push_back({ShaftKind::kLift, {{10, 10}, {20, 10}, {20, 20}}, "L"});
  ASSERT_OK_AND_ASSIGN(edited, ApplyEdits(before, drawn));
  EXPECT_TRUE(edited.changes.Any());
  EXPECT_EQ(edited.plan.shafts.size(), 1U);
}

TEST(ApplyEdits, WarnsOfWhatLooksLikeAMistake) {
  const PlanGraph before = ThreeRooms();
  PlanGraph drawn = before;
  drawn.doors.push_back({.from = {120, 40}, .to = {140, 40}});
  Draw(drawn, {100, 99.6}, {100.4, 100});
  drawn.corners.push_back({{33, 44}});
  ASSERT_OK_AND_ASSIGN(const EditedPlan edited, ApplyEdits(before, drawn));
  EXPECT_THAT(edited.warnings, ElementsAre(HasSubstr("the wall at (100.0, 100.0) is shorter"),
                                           "the door from (120.0, 40.0) to (140.0, 40.0) ends at no wall",
                                           HasSubstr("1 corners are where no wall ends")));
  EXPECT_EQ(edited.changes.walls_added, 0);
  EXPECT_TRUE(IsSame(edited.plan, before));
}

TEST(ApplyEdits, RefusesWhatIsNoPlan) {
  const PlanGraph before = ThreeRooms();
  PlanGraph drawn = before;
  drawn.walls.resize(7);
  EXPECT_STATUS(ApplyEdits(before, drawn), absl::StatusCode::kInvalidArgument, HasSubstr("7 walls, 8 needed"));
  drawn = before;
  drawn.walls[3].thickness = -1;
  EXPECT_STATUS(ApplyEdits(before, drawn), absl::StatusCode::kInvalidArgument, HasSubstr("wall 3 has a thickness"));
  drawn = before;
  drawn.metres_per_unit = 1e6;
  EXPECT_STATUS(ApplyEdits(before, drawn), absl::StatusCode::kInvalidArgument, HasSubstr("by its scale"));
  // Seven walls and one that vanishes.
  drawn = before;
  drawn.walls.resize(7);
  Draw(drawn, {100, 99.6}, {100.4, 100});
  EXPECT_STATUS(ApplyEdits(before, drawn), absl::StatusCode::kInvalidArgument, HasSubstr("7 walls, 8 needed"));
}

// Whatever is drawn, the plan is planar, and storing it once more changes nothing.
TEST(ApplyEdits, RandomEditsKeepThePlanPlanar) {
  std::mt19937 random(21);
  std::uniform_real_distribution<double> x(-20, 900), y(-20, 500), share(0, 1);
  for (int round = 0; round < 60; ++round) {
    PlanGraph before = Planarise(DrawnBuilding(), 1);
    PlanGraph drawn = before;
    for (int i = 0; i < 6; ++i) {
      Vector2d a(x(random), y(random)), b(x(random), y(random));
      const auto any = [&] {
        return static_cast<std::size_t>(share(random) * static_cast<double>(before.corners.size()));
      };
      if (share(random) < 0.5) a = before.corners[any()].point + Vector2d(share(random), -share(random)) / 3;
      if (share(random) < 0.3) b = before.corners[any()].point;
      if (share(random) < 0.2) {
        drawn.doors.push_back({.from = a, .to = b});
      } else {
        Draw(drawn, a, b);
      }
    }
    drawn.corners[static_cast<std::size_t>(share(random) * 20)].point += Vector2d(40, -25);
    drawn.walls.erase(drawn.walls.begin() + 5);
    ASSERT_OK_AND_ASSIGN(const EditedPlan edited, ApplyEdits(before, drawn));
    EXPECT_TRUE(IsPlanar(edited.plan)) << "round " << round;
    ASSERT_OK_AND_ASSIGN(const EditedPlan again, ApplyEdits(edited.plan, edited.plan));
    EXPECT_FALSE(again.changes.Any()) << "round " << round << ": " << Describe(again.changes);
  }
}

TEST(InsideOf, IsInsideAnAngledRoom) {
  const std::vector<Vector2d> angled = {{0, 0}, {100, 0}, {100, 10}, {10, 10}, {10, 100}, {0, 100}};
  EXPECT_EQ(InsideOf(angled), Vector2d(5, 50));
  EXPECT_EQ(AreaOf(angled), 1900);
}

}  // namespace
}  // namespace enfilade::prior
