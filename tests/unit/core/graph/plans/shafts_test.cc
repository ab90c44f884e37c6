// SPDX-License-Identifier: Apache-2.0
#include "core/graph/plans/shafts.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "core/graph/global_pose.h"
#include "core/graph/graph_optimization.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/core/graph/plans/floors.h"

namespace enfilade::graph {
namespace {

using ::testing::ElementsAre;
using testing::Floors;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr double kWanted = 0.15;  // m, of one floor relative to another

void Shift(ShaftInPlan& shaft, const Eigen::Vector2d& by) {
  for (Eigen::Vector2d& corner : shaft.outline) corner += by;
}

void ExpectSamePoses(const SolvedGraph& a, const SolvedGraph& b) {
  ASSERT_EQ(a.map_poses.size(), b.map_poses.size());
  for (const auto& [map, pose] : a.map_poses) {
    EXPECT_EQ(pose.pose, b.map_poses.at(map).pose) << map.value();
    EXPECT_EQ(pose.covariance, b.map_poses.at(map).covariance) << map.value();
  }
  EXPECT_EQ(a.disconnected, b.disconnected);
}

TEST(ShaftsTest, PlaceAFloorThatNothingJoins) {
  int within = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Floors floors(2, 3, 0.03, 0.0, seed);
    ASSERT_OK_AND_ASSIGN(const SolvedGraph solution, OptimizeGraph(floors.Graph({0, 1})));
    EXPECT_THAT(solution.disconnected, IsEmpty()) << "seed " << seed;
    for (int room = 0; room < 3; ++room) within += floors.ErrorOf(solution, 1, room).value_or(1e9) < kWanted ? 1 : 0;
    ASSERT_THAT(solution.plans, SizeIs(2));
    ASSERT_THAT(solution.plans[1].shafts, SizeIs(2));
    EXPECT_EQ(solution.plans[1].shafts[0].other, Floors::Plan(0));
    EXPECT_EQ(solution.plans[0].shafts[0].other, Floors::Plan(1));
    for (const ShaftUse& shaft : solution.plans[1].shafts) EXPECT_TRUE(shaft.used);
  }
  EXPECT_GE(within, 54) << "of 60, by plans whose corners are off by 3 cm";
}

TEST(ShaftsTest, PlaceFloorAfterFloor) {
  Floors floors(3, 3, 0.03, 0.0, 4);
  floors.ties(0).shafts[0].name = "C";  // floors 0 and 2 have one shaft in common, but both have two with floor 1
  floors.ties(1).shafts.push_back(floors.ties(1).shafts[0]);
  floors.ties(1).shafts.back().name = "C";
  ASSERT_OK_AND_ASSIGN(const SolvedGraph solution, OptimizeGraph(floors.Graph({0, 1, 2})));
  for (int room = 0; room < 3; ++room) EXPECT_LT(floors.ErrorOf(solution, 2, room).value_or(1e9), 0.25);
  ASSERT_OK_AND_ASSIGN(const SolvedGraph without, OptimizeGraph(floors.Graph({0, 2})));
  EXPECT_FALSE(without.map_poses.contains(floors.Map(2, 0)));
}

TEST(ShaftsTest, CovariancesSayHowFarFloorsAreOff) {
  int within = 0;
  constexpr int kSeeds = 200;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    Floors floors(2, 3, 0.05, kShaftSigma / std::sqrt(2.0), seed);  // of both floors together kShaftSigma
    ASSERT_OK_AND_ASSIGN(const SolvedGraph solution, OptimizeGraph(floors.Graph({0, 1})));
    within += floors.SurpriseOf(solution, 1, 2) < 7.815 ? 1 : 0;  // 95 % of chi-squared, 3 degrees of freedom
  }
  EXPECT_GE(within, 0.9 * kSeeds);
}

TEST(ShaftsTest, OneIsTooLittle) {
  Floors floors(2, 3, 0.05, 0.0, 1);
  floors.ties(1).shafts.pop_back();
  ASSERT_OK_AND_ASSIGN(const SolvedGraph below, OptimizeGraph(floors.Graph({0})));
  ASSERT_OK_AND_ASSIGN(const SolvedGraph solution, OptimizeGraph(floors.Graph({0, 1})));
  ExpectSamePoses(solution, below);
  EXPECT_THAT(solution.plans[1].shafts, IsEmpty());
}

TEST(ShaftsTest, WithoutThePlanEverythingIsAsBefore) {
  Floors floors(2, 3, 0.05, 0.0, 2);
  Floors unnamed(2, 3, 0.05, 0.0, 2);
  for (const int floor : {0, 1}) unnamed.ties(floor).shafts.clear();
  const std::vector<LinkPoint> doors = {floors.Door(0, 0, 0.03, 0.02), floors.Stairs(0, 2, 0.1, 0.05)};
  ASSERT_OK_AND_ASSIGN(const SolvedGraph one, OptimizeGraph(floors.Graph({0}, doors)));
  ASSERT_OK_AND_ASSIGN(const SolvedGraph one_unnamed, OptimizeGraph(unnamed.Graph({0}, doors)));
  ExpectSamePoses(one, one_unnamed);
  ASSERT_OK_AND_ASSIGN(const SolvedGraph both, OptimizeGraph(floors.Graph({0, 1}, doors)));
  ASSERT_OK_AND_ASSIGN(const SolvedGraph both_unnamed, OptimizeGraph(unnamed.Graph({0, 1}, doors)));
  EXPECT_NE(both.map_poses.at(floors.Map(1, 2)).pose, both_unnamed.map_poses.at(floors.Map(1, 2)).pose);
}

// Upstairs is known by one passage only, which turns it: two shafts turn it back.
TEST(ShaftsTest, HoldAFloorThatLinkPointsJoin) {
  double with = 0.0, without = 0.0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Floors floors(2, 4, 0.05, 0.05, seed);
    Floors unnamed(2, 4, 0.05, 0.05, seed);
    unnamed.ties(1).shafts.clear();
    const std::vector<LinkPoint> stairs = {floors.Stairs(0, 0, 0.1, 2.0 * kDegree)};
    ASSERT_OK_AND_ASSIGN(const SolvedGraph tied, OptimizeGraph(floors.Graph({0, 1}, stairs)));
    ASSERT_OK_AND_ASSIGN(const SolvedGraph untied, OptimizeGraph(unnamed.Graph({0, 1}, stairs)));
    with += floors.ErrorOf(tied, 1, 3).value_or(1e9);
    without += floors.ErrorOf(untied, 1, 3).value_or(1e9);
  }
  EXPECT_LT(with, 0.4 * without);
}

TEST(ShaftsTest, OneThatDisagreesIsSwitchedOff) {
  Floors floors(2, 3, 0.03, 0.0, 3);
  const std::vector<LinkPoint> stairs = {floors.Stairs(0, 0, 0.05, 0.01), floors.Stairs(0, 2, 0.05, 0.01)};
  Shift(floors.ties(1).shafts[0], {1.5, 0.0});
  ASSERT_OK_AND_ASSIGN(const SolvedGraph solution, OptimizeGraph(floors.Graph({0, 1}, stairs)));
  ASSERT_THAT(solution.plans[1].shafts, SizeIs(2));
  EXPECT_FALSE(solution.plans[1].shafts[0].used);
  EXPECT_NEAR(solution.plans[1].shafts[0].distance, 1.5, 0.2);
  EXPECT_TRUE(solution.plans[1].shafts[1].used);
  for (const int floor : {0, 1}) EXPECT_EQ(solution.plans[static_cast<std::size_t>(floor)].contradiction, "");
  for (int room = 0; room < 3; ++room) EXPECT_LT(floors.ErrorOf(solution, 1, room).value_or(1e9), kWanted);
}

TEST(ShaftsTest, OverruleNoLinkPoint) {
  Floors floors(2, 3, 0.03, 0.0, 3);
  const std::vector<LinkPoint> stairs = {floors.Stairs(0, 0, 0.4, 5.0 * kDegree)};
  for (ShaftInPlan& shaft : floors.ties(1).shafts) Shift(shaft, {3.0, 2.0});
  ASSERT_OK_AND_ASSIGN(const SolvedGraph solution, OptimizeGraph(floors.Graph({0, 1}, stairs)));
  ASSERT_THAT(solution.plans, SizeIs(2));
  for (const PlanUse& plan : solution.plans) {
    EXPECT_EQ(plan.contradiction, "") << "nobody can tell which one is wrong";
    ASSERT_THAT(plan.shafts, SizeIs(2));
    for (const ShaftUse& shaft : plan.shafts) EXPECT_FALSE(shaft.used);
  }
}

TEST(ShaftsTest, ThatLieOtherwiseToEachOtherPlaceNothing) {
  for (const bool farther : {true, false}) {
    Floors floors(2, 3, 0.03, 0.0, 3);
    std::vector<ShaftInPlan>& shafts = floors.ties(1).shafts;
    const Eigen::Vector2d way = (shafts[1].middle() - shafts[0].middle()).normalized();
    Shift(shafts[1], farther ? Eigen::Vector2d(3.0 * way) : Eigen::Vector2d(-5.0 * way.y(), 5.0 * way.x()));
    ASSERT_OK_AND_ASSIGN(const SolvedGraph below, OptimizeGraph(floors.Graph({0})));
    ASSERT_OK_AND_ASSIGN(const SolvedGraph solution, OptimizeGraph(floors.Graph({0, 1})));
    ExpectSamePoses(solution, below);
  }
}

TEST(ShaftsTest, OfThreePlansTheMajorityIsRight) {
  Floors floors(3, 3, 0.03, 0.0, 5);
  std::vector<LinkPoint> stairs;
  for (const int floor : {0, 1}) {
    for (const int room : {0, 2}) stairs.push_back(floors.Stairs(floor, room, 0.05, 0.01));
  }
  for (ShaftInPlan& shaft : floors.ties(1).shafts) Shift(shaft, {1.0, 1.0});
  ASSERT_OK_AND_ASSIGN(const SolvedGraph solution, OptimizeGraph(floors.Graph({0, 1, 2}, stairs)));
  EXPECT_EQ(solution.plans[0].contradiction, "");
  EXPECT_THAT(solution.plans[1].contradiction, HasSubstr("its shafts lie elsewhere than those of 2 plans"));
  EXPECT_EQ(solution.plans[2].contradiction, "");
  EXPECT_THAT(solution.plans[2].shafts, SizeIs(2));
}

TEST(ShaftsTest, HaveTheirShareOfAPose) {
  Floors floors(2, 3, 0.05, 0.0, 6);
  const GraphSnapshot graph = floors.Graph({0, 1});
  ASSERT_OK_AND_ASSIGN(SolvedGraph solution, OptimizeGraph(graph));
  const WorldPoses poses(Apply(graph, ChangesOf(graph, std::move(solution), graph.version() + 1)).value());
  ASSERT_OK_AND_ASSIGN(std::optional<GlobalPose> pose, poses.Find(floors.Map(1, 1), {{1.0, 2.0, 0.3}}));
  ASSERT_TRUE(pose.has_value());
  EXPECT_THAT(pose->plans, ElementsAre(Floors::Plan(1)));
  ASSERT_OK(ExplainPlans(poses.graph(), *pose));
  Eigen::Matrix3d sum = pose->base_share + pose->robot_share;
  std::vector<std::string> shafts;
  for (const PlanHop& hop : pose->plan_hops) {
    sum += hop.share;
    if (hop.shaft.empty()) continue;
    shafts.push_back(hop.shaft);
    EXPECT_EQ(hop.plan, Floors::Plan(0)) << "of the lower floor";
    EXPECT_GT(hop.share.trace(), 0.0);
  }
  EXPECT_THAT(shafts, ElementsAre("A", "B"));
  EXPECT_LT((sum - pose->T_world_robot.covariance).norm(), 1e-9);
}

TEST(SameShaftsTest, HaveNameKindAndShapeInCommon) {
  const auto count = [](void (*change)(PlanTies&)) {
    Floors floors(2, 3, 0.02, 0.0, 7);
    change(floors.ties(1));
    return SameShafts(floors.ties(0), floors.ties(1)).size();
  };
  EXPECT_EQ(count([](PlanTies&) {}), 2U);
  EXPECT_EQ(count([](PlanTies& ties) { ties.shafts[0].name = "a"; }), 1U);
  EXPECT_EQ(count([](PlanTies& ties) { ties.shafts[0].name = "B"; }), 0U) << "two have that name";
  EXPECT_EQ(count([](PlanTies& ties) { ties.shafts[0].is_lift = false; }), 1U);
  EXPECT_EQ(count([](PlanTies& ties) { ties.shafts[0].outline.pop_back(); }), 1U);
  EXPECT_EQ(count([](PlanTies& ties) {
              for (Eigen::Vector2d& corner : ties.shafts[0].outline) corner *= 1.5;
            }),
            1U)
      << "half as large again";
  EXPECT_EQ(count([](PlanTies& ties) {
              std::vector<Eigen::Vector2d>& outline = ties.shafts[0].outline;
              std::rotate(outline.begin(), outline.begin() + 1, outline.end());
            }),
            2U)
      << "drawn from another corner on";
}

TEST(SameShaftsTest, ThePlanSaysWhyItHasNoPlace) {
  Floors floors(2, 3, 0.02, 0.0, 8);
  const GraphSnapshot graph = floors.Graph({0});
  const std::vector<PlacedPlan> below = {{&graph.plans()[0], {}}};
  EXPECT_TRUE(PlaceByShafts(floors.ties(1), 1, below).T_world_plan.has_value());
  EXPECT_THAT(PlaceByShafts(floors.ties(1), 0, below).reason, HasSubstr("no shaft")) << "plans of one level";
  EXPECT_THAT(PlaceByShafts(floors.ties(1), 1, {}).reason, HasSubstr("no shaft"));
  PlanTies ties = floors.ties(1);
  const Eigen::Vector2d way = (ties.shafts[1].middle() - ties.shafts[0].middle()).normalized();
  Shift(ties.shafts[1], 4.0 * way);
  EXPECT_THAT(PlaceByShafts(ties, 1, below).reason, HasSubstr("lie otherwise to each other"));
  Shift(ties.shafts[1], -4.0 * way + Eigen::Vector2d(-5.0 * way.y(), 5.0 * way.x()));
  EXPECT_THAT(PlaceByShafts(ties, 1, below).reason, HasSubstr("are turned otherwise"));
  ties.shafts.pop_back();
  EXPECT_THAT(PlaceByShafts(ties, 1, below).reason, HasSubstr("only the shaft \"A\""));
}

}  // namespace
}  // namespace enfilade::graph
