// SPDX-License-Identifier: Apache-2.0
// Two robots see the doors between their halves of a building from both sides and go through none. A plan of it is put
// to use: with mapping, a database, and scans.
#include <gmock/gmock.h>

#include "tests/contract/closure/plan_doors_fixture.h"

namespace enfilade::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

// "south" is seen from both sides, "north" from the west only.
constexpr const char* kHalves = R"(campus: halves
areas:
  - id: west
    rect: [0, 0, 9, 12.5]
    doors: [{id: south, side: east, at: 3, width: 1.0}, {id: north, side: east, at: 10.5, width: 1.0}]
  - {id: east, rect: [9, 0, 8, 12.5]}
walls:
  - {points: [[0, 5.2], [3.6, 5.2]]}
  - {points: [[6.2, 5.6], [9, 5.6]]}
  - {points: [[3.6, 8.4], [5.6, 8.4], [5.6, 9.2]]}
  - {points: [[13.2, 7], [17, 7]]}
  - {points: [[11.8, 12.5], [11.8, 9.3]]}
  - {points: [[14.6, 0], [14.6, 1.6]]}
boxes:
  - {rect: [0.4, 2.6, 0.7, 1.4], height: 1.2}
  - {rect: [15.4, 4.2, 1.2, 0.8], height: 1.2}
robots:
  - id: west
    route:
      - [2.4, 2.2]
      - [4.4, 3]
      - [7.2, 3]
      - {wait: 2}
      - {turn_to_deg: 180}
      - [4.4, 3]
      - [5, 6.6]
      - [2.2, 7.0]
      - [2.2, 10.5]
      - [4.6, 10.5]
      - [7.2, 10.5]
      - {wait: 2}
      - {turn_to_deg: 180}
      - [3.4, 10.5]
  - id: east
    route:
      - [15.6, 2.8]
      - [13.4, 3.2]
      - [10.9, 3]
      - {wait: 2}
      - {turn_to_deg: 0}
      - [13.4, 3.2]
      - [12.2, 6]
      - [12.6, 8.4]
      - [15.2, 9.6]
)";

class PlanDoors : public PlanDoorsFixture {
 protected:
  void ImportPlan() {
    PlanDoorsFixture::ImportPlan({.seed = 5,
                                  .stretch = 0.02,
                                  .jitter = 0.1,
                                  .left_out = 0.0,
                                  .invented = 0.0,
                                  .door_shift = 0.2,
                                  .mirrored = 0.0});
  }
  void TakeBackAsAPerson() {
    const auto made = joins_.List(Soon(), site_);
    ASSERT_OK(made);
    ASSERT_THAT(*made, SizeIs(1));
    const auto lease = leases_.Acquire(Soon(), site_, "person", std::chrono::seconds(30));
    ASSERT_OK(lease);
    ASSERT_TRUE(lease->has_value());
    ASSERT_OK(rearranger_.Undo(Soon(), **lease, (*made)[0].rearrangement).status());
    ASSERT_OK(leases_.Release(Soon(), **lease));
    AwaitSolved();
  }
  std::vector<graph::LinkPoint> Joining() {
    std::vector<graph::LinkPoint> joining;
    for (const graph::LinkPoint* one : Graph()->graph().ListLinkPoints()) {
      if (!one->is_candidate()) joining.push_back(*one);
    }
    return joining;
  }
};

TEST_F(PlanDoors, ADoorThatRobotsSawFromBothSidesJoinsTheirMapsAsLongAsThePlanIsInUse) {
  MapBothHalves(kHalves);
  Decisions(Sessions());
  ImportPlan();
  EXPECT_EQ(Join(), 0) << "no plan is in use";
  const auto before = Graph();
  ASSERT_THAT(Joining(), IsEmpty());
  const std::size_t candidates = before->graph().link_point_count();
  ASSERT_GE(candidates, 3U);

  const storage::PriorMapOutcome outcome = Activate();
  ASSERT_TRUE(outcome.alignment) << outcome.reason;
  ASSERT_THAT(outcome.alignment->joined_maps, SizeIs(1)) << "the east half by the plan alone";
  EXPECT_EQ(Join(), 1);
  EXPECT_EQ(Join(), 0) << "nothing is left to be done";
  const std::vector<graph::LinkPoint> joining = Joining();
  ASSERT_THAT(joining, SizeIs(1));
  const graph::Anchor* west = joining[0].FindAnchor(map_);
  const graph::Anchor* east = joining[0].FindAnchor(east_);
  ASSERT_TRUE(west != nullptr && east != nullptr);
  const Pose2 at_west = InCampus(*west);
  const Pose2 at_east = InCampus(*east);
  const Pose2 off = Between(at_west, at_east);
  EXPECT_LT(off.translation().norm(), 0.1);
  EXPECT_LT(std::abs(off.yaw), 0.02);
  EXPECT_LT((at_west.translation() - Eigen::Vector2d(9.0, 3.0)).norm(), 0.4) << "it is at the door";
  const auto made = joins_.List(Soon(), site_);
  ASSERT_OK(made);
  ASSERT_THAT(*made, SizeIs(1));
  std::cout << (*made)[0].reason << "\n";
  EXPECT_THAT((*made)[0].reason, HasSubstr("lies on walls of the map"));

  Suspend();
  EXPECT_EQ(Join(), 1);
  EXPECT_THAT(Joining(), IsEmpty());
  const auto after = Graph();
  EXPECT_EQ(after->graph().link_point_count(), candidates);
  for (const graph::MapInGraph* map : after->graph().ListMaps()) {
    const auto then = before->poses.Find(map->id);
    const auto now = after->poses.Find(map->id);
    ASSERT_OK(then);
    ASSERT_OK(now);
    ASSERT_EQ(then->has_value(), now->has_value()) << map->id.value();
    if (!*then) continue;
    EXPECT_EQ((*then)->T_world_robot.pose, (*now)->T_world_robot.pose) << "bit for bit";
    EXPECT_EQ((*then)->T_world_robot.covariance, (*now)->T_world_robot.covariance);
  }

  // Put to use again, it joins them again; what a person takes back stays so.
  ASSERT_TRUE(Activate().alignment);
  EXPECT_EQ(Join(), 1);
  ASSERT_THAT(Joining(), SizeIs(1));
  TakeBackAsAPerson();
  EXPECT_EQ(Join(), 0);
  EXPECT_THAT(Joining(), IsEmpty());
}

}  // namespace
}  // namespace enfilade::testing
