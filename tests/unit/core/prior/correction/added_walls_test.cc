// SPDX-License-Identifier: Apache-2.0
#include "core/prior/correction/added_walls.h"

#include <gmock/gmock.h>

#include <initializer_list>

#include "tests/support/plans/drawn_building.h"

namespace enfilade::prior {
namespace {

using Eigen::Vector2d;
using ::testing::IsEmpty;
using ::testing::SizeIs;

const PlanTransform kInMap{.linear = 0.05 * Eigen::Matrix2d(Vector2d(1, -1).asDiagonal()), .offset = {3.0, 40.0}};

// What a robot has seen of `building`.
MapEvidence Seen(const PlanGraph& building) {
  return EvidenceOf(MapOf(building, kInMap, [](const Vector2d&) { return true; }));
}
std::vector<AddedWall> Added(const PlanGraph& plan, const MapEvidence& evidence) {
  return FindAddedWalls(CorrectedPlan(plan, evidence, kInMap), evidence);
}
double EndsOff(const AddedWall& wall, const Vector2d& from, const Vector2d& to) {
  const Vector2d a = kInMap(from), b = kInMap(to);
  return std::min(std::max((wall.from - a).norm(), (wall.to - b).norm()),
                  std::max((wall.from - b).norm(), (wall.to - a).norm()));
}

TEST(FindAddedWalls, NoneWhereThePlanHasThemAll) {
  const PlanGraph plan = DrawnBuilding();
  EXPECT_THAT(Added(plan, Seen(plan)), IsEmpty());
}

TEST(FindAddedWalls, TakesPartitionsThatThePlanLacks) {
  const PlanGraph plan = DrawnBuilding();
  PlanGraph building = plan;
  DrawWall(building, {200, 0}, {200, 120});    // into a room, from its wall
  DrawWall(building, {200, 120}, {150, 120});  // on from there
  DrawWall(building, {682, 200}, {878, 250});  // slanted, in the hall, from wall to wall
  const std::vector<AddedWall> added = Added(plan, Seen(building));
  ASSERT_THAT(added, SizeIs(3));
  EXPECT_LT(EndsOff(added[0], {682, 200}, {878, 250}), 0.6);
  EXPECT_LT(EndsOff(added[1], {200, 0}, {200, 120}), 0.6);
  EXPECT_LT(EndsOff(added[2], {200, 120}, {150, 120}), 0.3);
}

TEST(FindAddedWalls, TheTwoFacesOfAWallAreOne) {
  const PlanGraph plan = DrawnBuilding();
  PlanGraph building = plan;
  DrawWall(building, {180, 0}, {180, 130});
  DrawWall(building, {185, 0}, {185, 130});
  DrawWall(building, {180, 130}, {185, 130});
  const std::vector<AddedWall> added = Added(plan, Seen(building));
  ASSERT_THAT(added, SizeIs(1));
  EXPECT_LT(EndsOff(added[0], {182.5, 0}, {182.5, 130}), 0.6);
}

TEST(FindAddedWalls, LeavesFurniture) {
  const PlanGraph plan = DrawnBuilding();
  PlanGraph building = plan;
  // A table in the hall, a cupboard at its wall, and a short piece beside a door.
  const auto draw = [&](const std::initializer_list<Vector2d>& corners) {
    for (const Vector2d* corner = corners.begin(); corner + 1 != corners.end(); ++corner) {
      DrawWall(building, corner[0], corner[1]);
    }
  };
  draw({{740, 150}, {790, 150}, {790, 180}, {740, 180}, {740, 150}});
  draw({{868, 40}, {868, 80}});
  draw({{120, 40}, {120, 60}});
  EXPECT_THAT(Added(plan, Seen(building)), IsEmpty());
}

TEST(FindAddedWalls, FollowsTheCorrectedPlan) {
  // A wall that is drawn 0.4 m off is moved onto what robots have seen: it is not another wall.
  const PlanGraph building = DrawnBuilding();
  PlanGraph plan = building;
  for (PlanCorner& corner : plan.corners) {
    if (corner.point.x() == 12 * 20.0) corner.point.x() += 8;
  }
  EXPECT_THAT(Added(plan, Seen(building)), IsEmpty());
}

}  // namespace
}  // namespace enfilade::prior
