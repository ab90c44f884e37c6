// SPDX-License-Identifier: Apache-2.0
#include "perception/plan/walls/wall_doors.h"

#include <gtest/gtest.h>

#include <vector>

namespace enfilade::perception {
namespace {

using Eigen::Vector2d;

constexpr double kDiagonal = 1000;

// Walls, each from point to point; those that share a point share a corner.
prior::PlanGraph PlanOfWalls(const std::vector<std::pair<Vector2d, Vector2d>>& walls) {
  prior::PlanGraph plan;
  const auto corner = [&](const Vector2d& point) {
    for (std::size_t i = 0; i < plan.corners.size(); ++i) {
      if (plan.corners[i].point == point) return static_cast<int>(i);
    }
    plan.corners.push_back({point});
    return static_cast<int>(plan.corners.size()) - 1;
  };
  for (const auto& [from, to] : walls) {
    const int first = corner(from);
    plan.walls.push_back({.from = first, .to = corner(to), .thickness = 4});
  }
  return plan;
}

// One door between ends that face each other, 24 px wide.
const std::pair<Vector2d, Vector2d> kLeft = {{0, 0}, {100, 0}}, kRight = {{124, 0}, {224, 0}};

TEST(FindDoors, FindsTheGapBetweenTwoEndsInOneLine) {
  const auto doors = FindDoors(PlanOfWalls({kLeft, kRight}), kDiagonal);
  ASSERT_EQ(doors.size(), 1u);
  EXPECT_EQ(std::min(doors[0].from.x(), doors[0].to.x()), 100);
  EXPECT_EQ(std::max(doors[0].from.x(), doors[0].to.x()), 124);
}

TEST(FindDoors, FindsTheGapBetweenJambsThatWereDrawnAside) {
  // By a fifth of the gap, so that short walls turn, too.
  EXPECT_EQ(FindDoors(PlanOfWalls({{{40, 0}, {100, 5}}, {{124, -4}, {170, 0}}}), kDiagonal).size(), 1u);
  // By the whole gap: these are two walls side by side.
  EXPECT_TRUE(FindDoors(PlanOfWalls({{{0, 0}, {100, 0}}, {{124, 24}, {224, 24}}}), kDiagonal).empty());
}

TEST(FindDoors, LeavesAGapThatAWallCrosses) {
  EXPECT_TRUE(FindDoors(PlanOfWalls({kLeft, kRight, {{112, -10}, {112, 10}}}), kDiagonal).empty());
}

TEST(FindDoors, GivesEachEndOneDoor) {
  // The lower end points at the upper one nearly as well as the left one does.
  const auto doors = FindDoors(PlanOfWalls({kLeft, kRight, {{60, 30}, {102, 11}}}), kDiagonal);
  ASSERT_EQ(doors.size(), 1u);
  EXPECT_EQ(doors[0].from.y(), 0);
  EXPECT_EQ(doors[0].to.y(), 0);
}

TEST(FindDoors, FindsTheDoorBesideTheCornerOfARoom) {
  // The wall at the right bends at (224, 0), beside which the lower wall's end leaves a gap as wide as the other door.
  const auto doors = FindDoors(
      PlanOfWalls({kLeft, {{124, 0}, {200, 0}}, {{224, -60}, {224, 0}}, {{224, 0}, {300, 0}}, {{-50, 0}, {0, 0}}}),
      kDiagonal);
  EXPECT_EQ(doors.size(), 2u);
}

TEST(FindDoors, LeavesAWallThatEndsInARoom) {
  // It leaves another wall and points at the middle of a plain wall, three doors away and one and a half.
  for (const double gap : {72.0, 36.0}) {
    const auto doors = FindDoors(PlanOfWalls({kLeft,
                                              kRight,
                                              {{50, 300}, {50, 200}},
                                              {{0, 300}, {50, 300}},
                                              {{50, 300}, {100, 300}},
                                              {{-50, 200 - gap}, {150, 200 - gap}}}),
                                 kDiagonal);
    EXPECT_EQ(doors.size(), 1u) << gap;
  }
}

TEST(FindDoors, KeepsToWidthsOfDoorsWhereTheScaleIsKnown) {
  prior::PlanGraph plan = PlanOfWalls({kLeft, kRight});
  for (const auto& [metres, doors] : {std::pair{0.5, 0u}, {0.7, 1u}, {2.1, 1u}, {2.3, 0u}}) {
    plan.metres_per_unit = metres / 24;
    EXPECT_EQ(FindDoors(plan, kDiagonal).size(), doors) << metres;
  }
}

}  // namespace
}  // namespace enfilade::perception
