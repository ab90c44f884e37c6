// SPDX-License-Identifier: Apache-2.0
#include "core/closure/plans/plan_doors.h"

#include <gmock/gmock.h>

#include <cmath>
#include <string>
#include <vector>

#include "tests/support/status_assertions.h"

namespace enfilade::closure {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using State = SightedDoor::State;

// A wall along x = 0 with a door at y = 0; a map on each side of it, somehow turned, and another one to the west. Poses
// are given in the plan's frame.
class PlanDoorsTest : public ::testing::Test {
 protected:
  PlanDoorsTest() {
    plan_.walls = {{{0.0, -10.0}, {0.0, -0.5}}, {{0.0, 0.5}, {0.0, 10.0}}};
    AddDoor(0.0);
    for (const auto& [map, place] : std::vector<std::pair<std::string, Pose2>>{
             {"east", {5.0, 1.0, -1.0}}, {"west", {-5.0, 0.0, 0.3}}, {"west2", {-4.0, 3.0, 2.0}}}) {
      plan_.maps.push_back({MapId(map), place});
      changes_.maps.push_back({.id = MapId(map), .display_name = "The " + map});
    }
  }

  void AddDoor(double y, double sigma = 0.1) { plan_.doors.push_back({{0.0, y, 0.0}, 1.0, sigma}); }
  Pose2 InMap(const std::string& map, const Pose2& T_plan) const {
    for (const graph::MapInPlan& one : plan_.maps) {
      if (one.map == MapId(map)) return Between(one.T_plan_map, T_plan);
    }
    ADD_FAILURE() << map;
    return {};
  }
  graph::LinkPoint& Add(const std::string& id, const std::vector<std::pair<std::string, Pose2>>& anchors,
                        double sigma = 0.02) {
    graph::LinkPoint point;
    point.id = LinkPointId(id);
    const Eigen::Matrix3d covariance = Eigen::Vector3d(sigma * sigma, sigma * sigma, 1e-4).asDiagonal();
    for (const auto& [map, place] : anchors) point.anchors.push_back({MapId(map), InMap(map, place), covariance});
    changes_.link_points.push_back(point);
    return changes_.link_points.back();
  }
  void SeeFromBothSides() {
    Add("w", {{"west", {-1.8, 0.1, 0.05}}});
    Add("e", {{"east", {2.0, -0.1, M_PI - 0.1}}});
  }
  std::vector<SightedDoor> Find() {
    changes_.version = 1;
    const auto graph = graph::Apply(graph::GraphSnapshot(), changes_);
    EXPECT_OK(graph);
    return FindSightedDoors(plan_, *graph, options_);
  }

  PlanWithDoors plan_;
  graph::SnapshotChanges changes_;
  const DoorClosureOptions options_;
};

TEST_F(PlanDoorsTest, TwoMapsThatSeeADoorFromBothSidesAreToBeJoinedThere) {
  SeeFromBothSides();
  const SightedDoor door = Find()[0];
  ASSERT_EQ(door.state, State::kBothSides) << door.reason;
  EXPECT_EQ(door.sides[0].map, MapId("west")) << "x of the door points away from it";
  EXPECT_EQ(door.sides[1].map, MapId("east"));
  EXPECT_THAT(door.sides[0].candidates, ElementsAre(LinkPointId("w")));
  EXPECT_THAT(door.sides[1].candidates, ElementsAre(LinkPointId("e")));
  EXPECT_EQ(door.reason, "seen from The west and The east");
}

TEST_F(PlanDoorsTest, ADoorThatNobodySawHasNothingToSay) {
  Add("w", {{"west", {-1.8, 4.0, 0.0}}});
  const SightedDoor door = Find()[0];
  EXPECT_EQ(door.state, State::kNotSighted);
  EXPECT_THAT(door.reason, IsEmpty());
  EXPECT_THAT(door.candidates, IsEmpty());
}

TEST_F(PlanDoorsTest, OneSideIsNotEnough) {
  Add("w", {{"west", {-1.8, 0.0, 0.0}}});
  Add("again", {{"west", {-2.6, 0.2, 0.0}}});
  const SightedDoor door = Find()[0];
  EXPECT_EQ(door.state, State::kOneSide);
  EXPECT_THAT(door.candidates, ElementsAre(LinkPointId("again"), LinkPointId("w")));
  EXPECT_EQ(door.reason, "seen from one side only, in The west");
}

TEST_F(PlanDoorsTest, ARobotThatLooksAwayFromADoorSeesAnotherOne) {
  Add("w", {{"west", {-1.8, 0.0, 0.0}}});
  Add("e", {{"east", {2.0, 0.0, 0.0}}});
  EXPECT_EQ(Find()[0].state, State::kOneSide);
}

TEST_F(PlanDoorsTest, AMapOfBothSidesNeedsNoLinkPoint) {
  Add("w", {{"west", {-1.8, 0.0, 0.0}}});
  Add("e", {{"west", {2.0, 0.0, M_PI}}});
  EXPECT_EQ(Find()[0].state, State::kSameMap);
}

TEST_F(PlanDoorsTest, OfDoorsBesideEachOtherTheOneThatIsLookedAtCounts) {
  AddDoor(1.2);
  Add("w", {{"west", {-1.5, 0.0, 0.0}}});
  Add("e", {{"east", {1.5, 0.0, M_PI}}});
  Add("other", {{"east", {1.5, 1.25, M_PI}}});
  const std::vector<SightedDoor> doors = Find();
  EXPECT_EQ(doors[0].state, State::kBothSides) << doors[0].reason;
  EXPECT_EQ(doors[1].state, State::kOneSide) << doors[1].reason;
}

TEST_F(PlanDoorsTest, ARobotThatLooksBetweenTwoDoorsDecidesNeither) {
  AddDoor(1.2);
  Add("w", {{"west", {-1.5, 0.6, 0.0}}});
  Add("e", {{"east", {1.5, 0.0, M_PI}}});
  const std::vector<SightedDoor> doors = Find();
  EXPECT_EQ(doors[0].state, State::kOneSide) << doors[0].reason;
  EXPECT_THAT(doors[0].candidates, ElementsAre(LinkPointId("e"), LinkPointId("w")));
  EXPECT_EQ(doors[1].state, State::kUnclear);
  EXPECT_THAT(doors[1].reason, HasSubstr("another door"));
}

TEST_F(PlanDoorsTest, AMapBesideAnotherOnOneSideIsUnclear) {
  SeeFromBothSides();
  Add("w2", {{"west2", {-1.6, 0.0, 0.0}}});
  const SightedDoor door = Find()[0];
  EXPECT_EQ(door.state, State::kUnclear);
  EXPECT_EQ(door.reason, "seen from one side in several maps: The west, The west2");
}

TEST_F(PlanDoorsTest, ADoorWithALinkPointIsLeftAlone) {
  SeeFromBothSides();
  for (const auto use :
       {graph::LinkPointUse::kUsed, graph::LinkPointUse::kSwitchedOff, graph::LinkPointUse::kSuspended}) {
    graph::LinkPoint& known = Add("known", {{"west", {0.1, 0.7, 0.0}}, {"east", {0.1, 0.7, 0.0}}});
    known.use = use;
    const SightedDoor door = Find()[0];
    EXPECT_EQ(door.state, State::kKnown);
    EXPECT_EQ(door.link_point, LinkPointId("known"));
    changes_.link_points.pop_back();
  }
}

TEST_F(PlanDoorsTest, TheLinkPointOfTheDoorBesideItIsAnother) {
  AddDoor(1.2);
  Add("w", {{"west", {-1.5, 0.0, 0.0}}});
  Add("e", {{"east", {1.5, 0.0, M_PI}}});
  Add("known", {{"west", {0.0, 0.9, 0.0}}, {"east", {0.0, 0.9, 0.0}}});
  const std::vector<SightedDoor> doors = Find();
  EXPECT_EQ(doors[0].state, State::kBothSides);
  EXPECT_EQ(doors[1].link_point, LinkPointId("known"));
}

TEST_F(PlanDoorsTest, ADoorBehindAWallOrAnotherDoorIsNotSeen) {
  plan_.walls.emplace_back(Eigen::Vector2d(-1.0, -3.0), Eigen::Vector2d(-1.0, 3.0));
  SeeFromBothSides();
  EXPECT_EQ(Find()[0].state, State::kOneSide);
  plan_.walls.pop_back();
  EXPECT_EQ(Find()[0].state, State::kBothSides);
  plan_.doors.push_back({{1.2, 0.0, 0.0}, 1.0, 0.1});
  EXPECT_EQ(Find()[0].state, State::kOneSide);
}

TEST_F(PlanDoorsTest, ADoorThatThePlanHardlyKnowsIsUnclear) {
  plan_.doors[0].sigma = 0.6;
  SeeFromBothSides();
  const SightedDoor door = Find()[0];
  EXPECT_EQ(door.state, State::kUnclear);
  EXPECT_THAT(door.reason, HasSubstr("1.5 m only"));
}

TEST_F(PlanDoorsTest, SuspendedCandidatesAndMapsThatThePlanDoesNotKnowDoNotCount) {
  SeeFromBothSides();
  changes_.link_points[1].use = graph::LinkPointUse::kSuspended;
  EXPECT_EQ(Find()[0].state, State::kOneSide);
  changes_.link_points[1].use = graph::LinkPointUse::kUsed;
  plan_.maps.erase(plan_.maps.begin());
  EXPECT_EQ(Find()[0].state, State::kOneSide);
  EXPECT_FALSE(DoorInMap(plan_, plan_.doors[0], MapId("east")));
}

TEST_F(PlanDoorsTest, ADoorIsWhereThePlanHasItInTheMap) {
  const auto door = DoorInMap(plan_, plan_.doors[0], MapId("west"));
  ASSERT_TRUE(door);
  const Pose2 expected = InMap("west", {0.0, 0.0, 0.0});
  EXPECT_NEAR((door->pose.translation() - expected.translation()).norm(), 0.0, 1e-12);
  EXPECT_NEAR(door->pose.yaw, expected.yaw, 1e-12);
  EXPECT_NEAR(door->covariance(0, 0), 0.01, 1e-12);
}

}  // namespace
}  // namespace enfilade::closure
