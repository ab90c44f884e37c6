// SPDX-License-Identifier: Apache-2.0
#include "core/graph/solve/extend_solution.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "core/graph/graph_optimization.h"
#include "tests/support/pose_matchers.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/core/graph/scene.h"

namespace enfilade::graph {
namespace {

using testing::AnchorIn;
using testing::Graph;
using testing::Joining;
using testing::L;
using testing::M;
using testing::Numbered;
using testing::PoseNear;
using testing::RandomCovariance;
using testing::RandomWorld;
using testing::Uniform;
using testing::World;

// Twelve maps of which the first six are joined, with loops, and solved.
class ExtendSolutionTest : public ::testing::TestWithParam<int> {
 protected:
  ExtendSolutionTest() {
    std::vector<LinkPoint> doors;
    for (int i = 1; i < 6; ++i) doors.push_back(Door(Numbered("d", i), i - 1, i));
    doors.push_back(Door("loop", 0, 3));
    doors.push_back(Door("chord", 1, 5));
    LinkPoint suspended = Door("suspended", 2, 7);
    suspended.use = LinkPointUse::kSuspended;
    doors.push_back(suspended);
    const GraphSnapshot graph = Graph(world_.MapIds(), doors);
    solution_ = OptimizeGraph(graph).value();
    solved_ = Apply(graph, ChangesOf(graph, solution_, graph.version() + 1)).value();
  }

  LinkPoint Door(const std::string& id, int a, int b) {
    return world_.See(id, {Uniform(0, 40, random_), Uniform(0, 40, random_), Uniform(-3, 3, random_)}, {a, b},
                      {RandomCovariance(0.05, 0.01, random_), RandomCovariance(0.05, 0.01, random_)}, random_);
  }
  std::optional<SolvedGraph> Extend(const GraphSnapshot& graph) const {
    return ExtendSolution(solved_, solution_, graph);
  }

  std::mt19937_64 random_{static_cast<std::uint64_t>(GetParam())};
  World world_ = RandomWorld(12, 40.0, random_);
  GraphSnapshot solved_;
  SolvedGraph solution_;
};

TEST_P(ExtendSolutionTest, BranchesGetThePosesOfTheOptimum) {
  // 6 and 8 hang on 2, 7 on 6; 9 and 10 are joined to each other only, 11 to nothing.
  const GraphSnapshot graph =
      Graph({}, {Door("b7", 6, 7), Door("b6", 2, 6), Door("b8", 8, 2), Door("island", 9, 10)}, solved_);
  const std::optional<SolvedGraph> extended = Extend(graph);
  ASSERT_TRUE(extended.has_value());
  ASSERT_OK_AND_ASSIGN(const SolvedGraph expected, OptimizeGraph(graph));
  EXPECT_EQ(extended->map_poses.size(), 9U);
  EXPECT_EQ(extended->map_poses.size(), expected.map_poses.size());
  for (const auto& [map, pose] : expected.map_poses) {
    const PoseWithCovariance& found = extended->map_poses.at(map);
    EXPECT_THAT(found.pose, PoseNear(pose.pose, 1e-5, 1e-6)) << map.value();
    EXPECT_LT((found.covariance - pose.covariance).norm(), 1e-5 * pose.covariance.norm() + 1e-12) << map.value();
  }
  EXPECT_EQ(extended->disconnected, expected.disconnected);
  EXPECT_EQ(extended->degrees_of_freedom, expected.degrees_of_freedom);
  EXPECT_EQ(extended->graph_version, graph.version());
}

TEST_P(ExtendSolutionTest, WhatMayMoveMapsMustBeSolved) {
  EXPECT_FALSE(Extend(Graph({}, {Door("again", 0, 5)}, solved_)).has_value()) << "a loop";
  EXPECT_FALSE(Extend(Graph({}, {Door("one", 2, 6), Door("two", 4, 6)}, solved_)).has_value()) << "two ways to 6";
  EXPECT_FALSE(Extend(Graph({}, {Door("b6", 2, 6), Door("b7", 6, 7), Door("b8", 7, 8), Door("back", 8, 6)}, solved_))
                   .has_value())
      << "a loop among new maps";
  LinkPoint moved = *solved_.FindLinkPoint(L("loop"));
  moved.anchors[0].T_map_place.x += 0.1;
  EXPECT_FALSE(Extend(Graph({}, {moved}, solved_)).has_value());
  LinkPoint off = *solved_.FindLinkPoint(L("loop"));
  off.use = LinkPointUse::kSuspended;
  EXPECT_FALSE(Extend(Graph({}, {off}, solved_)).has_value());
  LinkPoint on = *solved_.FindLinkPoint(L("suspended"));
  on.use = LinkPointUse::kUsed;
  EXPECT_TRUE(Extend(Graph({}, {on}, solved_)).has_value()) << "7 hangs on it";
  ASSERT_OK_AND_ASSIGN(const GraphSnapshot removed,
                       Apply(solved_, {.version = solved_.version() + 1, .removed_link_points = {L("chord")}}));
  EXPECT_FALSE(Extend(removed).has_value());
}

TEST_P(ExtendSolutionTest, WhatIsNotMeasuredChangesNothing) {
  LinkPoint tagged = *solved_.FindLinkPoint(L("loop"));
  tagged.tag = "fire door";
  tagged.state = PassageState::kClosed;
  const auto extended = Extend(Graph({"new"}, {tagged, Joining("seen", {AnchorIn("m3", {1, 2, 0})})}, solved_));
  ASSERT_TRUE(extended.has_value());
  EXPECT_EQ(extended->map_poses.size(), solution_.map_poses.size());
}

INSTANTIATE_TEST_SUITE_P(Seeds, ExtendSolutionTest, ::testing::Range(1, 9));

}  // namespace
}  // namespace enfilade::graph
