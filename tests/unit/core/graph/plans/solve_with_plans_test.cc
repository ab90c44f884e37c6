// SPDX-License-Identifier: Apache-2.0
#include "core/graph/plans/solve_with_plans.h"

#include <gmock/gmock.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <functional>

#include "core/graph/global_pose.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/core/graph/plans/row_of_rooms.h"
#include "tests/unit/core/graph/scene.h"

namespace enfilade::graph {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

using Row = testing::RowOfRooms;

TEST(SolveWithPlansTest, AMapThatNoLinkPointJoinsIsPosed) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Row row(2, 0.1, seed);
    row.SeeAll(0);
    row.SeeAll(1);
    ASSERT_OK_AND_ASSIGN(const SolvedGraph solution, OptimizeGraph(row.WithPlan({})));
    EXPECT_THAT(solution.disconnected, IsEmpty());
    EXPECT_LT(row.ErrorOf(solution, 1), 0.4);
    ASSERT_THAT(solution.plans, SizeIs(1));
    EXPECT_EQ(solution.plans[0].used + solution.plans[0].switched_off, 8);
    EXPECT_EQ(solution.plans[0].contradiction, "");
  }
}

// Across the wall that both see, the plan's errors do not matter.
TEST(SolveWithPlansTest, MapsThatSeeTheSameWallAreTiedByIt) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Row row(2, 0.2, seed);
    row.SeeAll(0);
    row.SeeAll(1);
    ASSERT_OK_AND_ASSIGN(const SolvedGraph solution, OptimizeGraph(row.WithPlan({})));
    const Pose2 truth = row.world().T_world_maps[1];
    ASSERT_THAT(solution.disconnected, IsEmpty()) << "seed " << seed << solution.plans[0].contradiction;
    EXPECT_NEAR(solution.map_poses.at(Row::Map(1)).pose.x, truth.x, 0.2);
    EXPECT_NEAR(WrapAngle(solution.map_poses.at(Row::Map(1)).pose.yaw - truth.yaw), 0.0, 0.03);
  }
}

TEST(SolveWithPlansTest, MapsWithoutPlanStayWhereTheyAre) {
  Row row(2, 0.1, 1);
  const std::vector<LinkPoint> doors = {row.Door(0, 0.05, 0.02)};
  ASSERT_OK_AND_ASSIGN(const SolvedGraph without, OptimizeGraph(row.WithoutPlan(doors)));
  ASSERT_OK_AND_ASSIGN(const SolvedGraph unseen, OptimizeGraph(row.WithPlan(doors)));  // nobody has seen its walls
  EXPECT_EQ(unseen.map_poses.at(Row::Map(1)).pose, without.map_poses.at(Row::Map(1)).pose);
  EXPECT_THAT(unseen.plans, ElementsAre(PlanUse{.plan = PriorMapId("p")}));
}

// Of a chain of rooms each door bends it by 1.5 degrees.
TEST(SolveWithPlansTest, AChainOfRoomsBendsLess) {
  double with_plan = 0.0, without_plan = 0.0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Row row(8, 0.1, seed);
    std::vector<LinkPoint> doors;
    for (int i = 0; i < 7; ++i) doors.push_back(row.Door(i, 0.03, 1.5 * kDegree));
    for (int i = 0; i < 8; ++i) row.SeeAll(i);
    ASSERT_OK_AND_ASSIGN(const SolvedGraph without, OptimizeGraph(row.WithoutPlan(doors)));
    ASSERT_OK_AND_ASSIGN(const SolvedGraph with, OptimizeGraph(row.WithPlan(doors)));
    without_plan += row.ErrorOf(without, 7);
    with_plan += row.ErrorOf(with, 7);
    EXPECT_EQ(with.plans[0].contradiction, "") << "seed " << seed;
  }
  EXPECT_LT(with_plan, 0.3 * without_plan);
}

TEST(SolveWithPlansTest, CovariancesSayHowFarPosesAreOff) {
  int within = 0;
  constexpr int kSeeds = 200;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    Row row(3, 0.1, seed);
    row.Bend(0.03);
    std::vector<LinkPoint> doors = {row.Door(0, 0.05, 1.0 * kDegree)};
    for (int i = 0; i < 3; ++i) row.SeeAll(i);
    ASSERT_OK_AND_ASSIGN(const SolvedGraph solution, OptimizeGraph(row.WithPlan(doors)));
    within += row.SurpriseOf(solution, 2) < 7.815 ? 1 : 0;  // 95 % of chi-squared, 3 degrees of freedom
  }
  EXPECT_GE(within, 0.9 * kSeeds);
  EXPECT_LE(within, 0.99 * kSeeds);
}

TEST(SolveWithPlansTest, WallsThatAreTakenForOthersAreSwitchedOff) {
  double with_plan = 0.0, without_plan = 0.0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Row row(6, 0.05, seed);
    std::vector<LinkPoint> doors;
    for (int i = 0; i < 5; ++i) doors.push_back(row.Door(i, 0.03, 1.0 * kDegree));
    for (int i = 0; i < 6; ++i) row.SeeAll(i);
    for (std::size_t i = 4; i < row.ties().sightings.size(); i += 4) {  // the wall to the room before
      Pose2& line = row.ties().sightings[i].T_map_line;
      line = line * Pose2{0.0, 1.0, 0.0};
    }
    ASSERT_OK_AND_ASSIGN(const SolvedGraph without, OptimizeGraph(row.WithoutPlan(doors)));
    ASSERT_OK_AND_ASSIGN(const SolvedGraph solution, OptimizeGraph(row.WithPlan(doors)));
    EXPECT_EQ(solution.plans[0].contradiction, "");
    EXPECT_GE(solution.plans[0].switched_off, 5);
    with_plan += row.ErrorOf(solution, 5);
    without_plan += row.ErrorOf(without, 5);
  }
  EXPECT_LT(with_plan, 0.6 * without_plan);
}

// The last wall is taken for one 3 m behind it, by all maps alike: the walls that end there would be half as long
// again.
TEST(SolveWithPlansTest, AWallThatWouldBeStretchedTooMuchDoesNotCostThePlan) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    Row row(4, 0.05, seed);
    std::vector<LinkPoint> doors;
    for (int i = 0; i < 3; ++i) doors.push_back(row.Door(i, 0.03, 1.0 * kDegree));
    for (int i = 0; i < 4; ++i) row.SeeAll(i);
    for (int i = 0; i < 3; ++i) row.See(i, 4);
    for (WallSighting& sighting : row.ties().sightings) {
      if (sighting.strut == 4) sighting.T_map_line = sighting.T_map_line * Pose2{0.0, -3.0, 0.0};
    }
    ASSERT_OK_AND_ASSIGN(const SolvedGraph solution, OptimizeGraph(row.WithPlan(doors)));
    EXPECT_EQ(solution.plans[0].contradiction, "") << "seed " << seed;
    EXPECT_GE(solution.plans[0].switched_off, 4) << "seed " << seed;
    for (int i = 1; i < 4; ++i) EXPECT_LT(row.ErrorOf(solution, i), 0.25) << "seed " << seed;
  }
}

TEST(SolveWithPlansTest, APlanOfAnotherBuildingChangesNothing) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    Row row(6, 0.05, seed);
    std::vector<LinkPoint> doors;
    for (int i = 0; i < 5; ++i) doors.push_back(row.Door(i, 0.03, 1.0 * kDegree));
    for (int i = 0; i < 6; ++i) row.SeeAll(i);
    std::mt19937_64 random(seed);
    for (WallSighting& sighting : row.ties().sightings) {
      sighting.T_map_line = sighting.T_map_line * Pose2{0.0, testing::Uniform(-2.0, 2.0, random), 0.0};
    }
    ASSERT_OK_AND_ASSIGN(const SolvedGraph without, OptimizeGraph(row.WithoutPlan(doors)));
    ASSERT_OK_AND_ASSIGN(const SolvedGraph solution, OptimizeGraph(row.WithPlan(doors)));
    EXPECT_NE(solution.plans[0].contradiction, "") << "seed " << seed;
    for (const auto& [map, pose] : without.map_poses) {
      EXPECT_EQ(solution.map_poses.at(map).pose, pose.pose);
      EXPECT_EQ(solution.map_poses.at(map).covariance, pose.covariance);
    }
  }
}

// All rooms of the plan are a tenth too wide, and the doors are known well.
TEST(SolveWithPlansTest, LinkPointsRefuteAPlanThatIsConsistentlyWrong) {
  Row row(6, 0.02, 1);
  row.ties().stretch_sigma = 0.01;
  std::vector<LinkPoint> doors;
  for (int i = 0; i < 5; ++i) doors.push_back(row.Door(i, 0.01, 0.2 * kDegree));
  for (int i = 0; i < 6; ++i) row.SeeAll(i);
  for (Eigen::Vector2d& corner : row.ties().corners) corner.x() *= 1.1;
  for (WallSighting& sighting : row.ties().sightings) sighting.across_sigma = 0.2;  // so that no single one stands out
  ASSERT_OK_AND_ASSIGN(const SolvedGraph without, OptimizeGraph(row.WithoutPlan(doors)));
  ASSERT_OK_AND_ASSIGN(const SolvedGraph solution, OptimizeGraph(row.WithPlan(doors)));
  const double moved = std::abs(solution.map_poses.at(Row::Map(5)).pose.x - without.map_poses.at(Row::Map(5)).pose.x);
  EXPECT_TRUE(!solution.plans[0].contradiction.empty() || moved < 0.05) << moved;
}

// What T_world_robot has of its covariance, by ExplainPlans.
Eigen::Matrix3d SumOfShares(const GlobalPose& pose) {
  Eigen::Matrix3d sum = pose.base_share + pose.robot_share;
  for (const PoseHop& hop : pose.hops) sum += hop.share;
  for (const PlanHop& hop : pose.plan_hops) sum += hop.share;
  return sum;
}

TEST(SolveWithPlansTest, EachWallHasItsShareOfAPose) {
  Row row(2, 0.1, 5);
  row.SeeAll(0);
  row.SeeAll(1);
  row.ties().sightings.back().across_sigma = 3.0;  // hardly seen
  const GraphSnapshot graph = row.WithPlan({});
  ASSERT_OK_AND_ASSIGN(SolvedGraph solution, OptimizeGraph(graph));
  EXPECT_THAT(solution.plan_shares, IsEmpty()) << "nobody has asked";
  const WorldPoses poses(Apply(graph, ChangesOf(graph, std::move(solution), graph.version() + 1)).value());
  const Eigen::Matrix3d of_robot = Eigen::Vector3d(0.01, 0.04, 0.0001).asDiagonal();
  ASSERT_OK_AND_ASSIGN(std::optional<GlobalPose> pose, poses.Find(Row::Map(1), {{2.0, -1.0, 0.4}, of_robot}));
  ASSERT_TRUE(pose.has_value());
  const Eigen::Matrix3d whole_base = pose->base_share;
  ASSERT_OK(ExplainPlans(poses.graph(), *pose));
  std::vector<int> walls;
  for (const PlanHop& hop : pose->plan_hops) {
    EXPECT_EQ(hop.plan, PriorMapId("p"));
    walls.push_back(hop.wall);
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(hop.share).eigenvalues()(0), -1e-9);
  }
  EXPECT_THAT(walls, ElementsAre(-1, 1, 2, row.Below(1), row.Below(1) + 1));
  EXPECT_LT((SumOfShares(*pose) - pose->T_world_robot.covariance).norm(), 1e-9);
  // Only the plan joins the map, so nearly all of its covariance comes from there: the rest is what SLAM bends maps.
  EXPECT_LT(pose->base_share.trace(), 0.5 * whole_base.trace());
  // The map has two walls that tell where it is across the row; of these the one that is hardly seen counts less.
  EXPECT_LT(pose->plan_hops[4].share.trace(), pose->plan_hops[3].share.trace());
}

TEST(SolveWithPlansTest, WithoutPlansNothingIsExplained) {
  Row row(2, 0.1, 5);
  const std::vector<LinkPoint> doors = {row.Door(0, 0.05, 0.02)};
  const WorldPoses poses(row.WithoutPlan(doors));
  ASSERT_OK_AND_ASSIGN(std::optional<GlobalPose> pose, poses.Find(Row::Map(1)));
  ASSERT_OK(ExplainPlans(poses.graph(), *pose));
  EXPECT_THAT(pose->plan_hops, IsEmpty());
}

TEST(SolveWithPlansTest, InACorridorAMapIsNotPosed) {
  Row row(2, 0.1, 1);
  row.SeeAll(0);
  for (const int side : {0, 1}) row.See(1, row.Below(1) + side);  // parallel walls only
  ASSERT_OK_AND_ASSIGN(const SolvedGraph solution, OptimizeGraph(row.WithPlan({})));
  EXPECT_THAT(solution.disconnected, ElementsAre(Row::Map(1)));
  EXPECT_FALSE(solution.map_poses.contains(Row::Map(1)));
}

// Maps that only the plan joins bring those with them that link points join to them.
TEST(SolveWithPlansTest, WhatIsJoinedToAPosedMapIsPosedToo) {
  Row row(4, 0.1, 3);
  row.SeeAll(0);
  row.SeeAll(2);
  const std::vector<LinkPoint> doors = {row.Door(2, 0.03, 1.0 * kDegree)};
  ASSERT_OK_AND_ASSIGN(const SolvedGraph solution, OptimizeGraph(row.WithPlan(doors)));
  EXPECT_THAT(solution.disconnected, ElementsAre(Row::Map(1)));
  EXPECT_LT(row.ErrorOf(solution, 2), 0.6);
  EXPECT_LT(row.ErrorOf(solution, 3), 0.8);
}

TEST(SolveWithPlansTest, SolvingAgainChangesNothing) {
  Row row(4, 0.1, 5);
  for (int i = 0; i < 4; ++i) row.SeeAll(i);
  const GraphSnapshot graph = row.WithPlan({row.Door(0, 0.03, 1.0 * kDegree)});
  ASSERT_OK_AND_ASSIGN(const SolvedGraph first, OptimizeGraph(graph));
  ASSERT_OK_AND_ASSIGN(const GraphSnapshot solved, Apply(graph, ChangesOf(graph, first, graph.version() + 1)));
  ASSERT_OK_AND_ASSIGN(const SolvedGraph second, OptimizeGraph(solved));
  for (const auto& [map, pose] : first.map_poses) {
    EXPECT_NEAR((second.map_poses.at(map).pose.translation() - pose.pose.translation()).norm(), 0.0, 1e-6);
  }
}

TEST(SolveWithPlansTest, OfTwoPlansAWrongOneLeavesTheOther) {
  Row row(5, 0.05, 2);
  for (int i = 0; i < 5; ++i) row.SeeAll(i);
  PlanTies wrong = row.ties();
  std::mt19937_64 random(1);
  for (WallSighting& sighting : wrong.sightings) {
    sighting.T_map_line = sighting.T_map_line * Pose2{0.0, testing::Uniform(-2.0, 2.0, random), 0.0};
  }
  const GraphSnapshot graph = testing::Graph(row.world().MapIds(), {});
  ASSERT_OK_AND_ASSIGN(const GraphSnapshot both,
                       Apply(graph, {.version = graph.version() + 1,
                                     .plans = std::vector<PlanInGraph>{
                                         {PriorMapId("right"), "1", std::make_shared<const PlanTies>(row.ties())},
                                         {PriorMapId("wrong"), "2", std::make_shared<const PlanTies>(wrong)}}}));
  ASSERT_OK_AND_ASSIGN(const SolvedGraph solution, OptimizeGraph(both));
  ASSERT_THAT(solution.plans, SizeIs(2));
  EXPECT_EQ(solution.plans[0].contradiction, "");
  EXPECT_THAT(solution.plans[1].contradiction, HasSubstr("do not fit"));
  for (int i = 1; i < 5; ++i) EXPECT_LT(row.ErrorOf(solution, i), 0.4);
}

}  // namespace
}  // namespace enfilade::graph
