// SPDX-License-Identifier: Apache-2.0
#include "core/graph/solve/compare_solutions.h"

#include <memory>

#include "gmock/gmock.h"
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
using testing::PoseNear;

struct SolvedRow {
  GraphSnapshot graph;
  std::shared_ptr<const SolvedGraph> solution;

  GraphWithSolution with() const { return {graph, solution}; }
};

SolvedRow SolveRow(const std::vector<LinkPoint>& link_points) {
  SolvedRow solved{Graph({"a", "b", "c"}, link_points), nullptr};
  auto solution = OptimizeGraph(solved.graph);
  EXPECT_OK(solution);
  solved.solution = std::make_shared<const SolvedGraph>(*std::move(solution));
  return solved;
}

// a - b, and twice b - c, 5 m along x each.
std::vector<LinkPoint> DoorsInARow(const Pose2& T_c_second = {0, 2, 0}) {
  return {Joining("ab", {AnchorIn("a", {5, 0, 0}), AnchorIn("b", {})}),
          Joining("bc", {AnchorIn("b", {5, 0, 0}), AnchorIn("c", {})}),
          Joining("bc2", {AnchorIn("b", {5, 2, 0}), AnchorIn("c", T_c_second)})};
}

TEST(CompareSolutionsTest, NothingMovesIfNothingChanges) {
  const SolvedRow before = SolveRow(DoorsInARow());
  ASSERT_OK_AND_ASSIGN(const auto difference, CompareSolutions(before.with(), before.with(), {}));
  EXPECT_TRUE(difference.moved.empty());
  EXPECT_TRUE(difference.residuals.empty());
}

TEST(CompareSolutionsTest, ListsTheFarthestMovedFirst) {
  const SolvedRow before = SolveRow(DoorsInARow());
  std::vector<LinkPoint> turned = DoorsInARow();
  turned[0].anchors[0].T_map_place.yaw = 0.2;
  const SolvedRow after = SolveRow(turned);
  ASSERT_OK_AND_ASSIGN(const auto difference, CompareSolutions(before.with(), after.with(), {L("ab")}));
  ASSERT_EQ(difference.moved.size(), 2U);
  EXPECT_EQ(difference.moved[0].map, M("c"));
  EXPECT_EQ(difference.moved[1].map, M("b"));
  EXPECT_THAT(difference.moved[1].T_world_map_before->pose, PoseNear(Pose2{5, 0, 0}, 1e-6, 1e-6));
  EXPECT_THAT(difference.moved[1].T_world_map_after->pose, PoseNear(Pose2{5, 0, 0.2}, 1e-6, 1e-6));
  ASSERT_EQ(difference.residuals.size(), 1U);
  EXPECT_EQ(difference.residuals[0].link_point, L("ab"));
  EXPECT_NEAR(difference.residuals[0].chi2_after, 0.0, 1e-6);
}

TEST(CompareSolutionsTest, MapsThatGainOrLoseTheirPlaceComeFirst) {
  std::vector<LinkPoint> cut = DoorsInARow();
  cut[0].anchors[0].T_map_place.x = 6;
  cut[1].use = cut[2].use = LinkPointUse::kSuspended;
  const SolvedRow before = SolveRow(DoorsInARow());
  const SolvedRow after = SolveRow(cut);
  ASSERT_OK_AND_ASSIGN(auto difference, CompareSolutions(before.with(), after.with(), {L("bc")}));
  ASSERT_EQ(difference.moved.size(), 2U);
  EXPECT_EQ(difference.moved[0].map, M("c"));
  EXPECT_FALSE(difference.moved[0].T_world_map_after);
  EXPECT_GT(difference.residuals[0].gate, 0.0);
  ASSERT_OK_AND_ASSIGN(difference, CompareSolutions(after.with(), before.with(), {}));
  EXPECT_FALSE(difference.moved[0].T_world_map_before);
  EXPECT_TRUE(difference.moved[0].T_world_map_after);
}

// The residuals are those that the optimisation judges by.
TEST(CompareSolutionsTest, WhatIsSwitchedOffHasTheChi2OfTheOptimisation) {
  std::vector<LinkPoint> link_points = DoorsInARow({0, 5, 0});
  link_points.push_back(Joining("bc3", {AnchorIn("b", {5, -3, 0}), AnchorIn("c", {0, -3, 0})}));
  std::vector<LinkPoint> fitting = link_points;
  fitting[2] = DoorsInARow()[2];
  const SolvedRow before = SolveRow(fitting);
  const SolvedRow after = SolveRow(link_points);
  ASSERT_EQ(after.solution->switched_off.size(), 1U);
  ASSERT_OK_AND_ASSIGN(const auto difference, CompareSolutions(before.with(), after.with(), {}));
  ASSERT_EQ(difference.residuals.size(), 1U);
  const ResidualChange& off = difference.residuals[0];
  EXPECT_EQ(off.link_point, L("bc2"));
  EXPECT_FALSE(off.switched_off_before);
  EXPECT_TRUE(off.switched_off_after);
  EXPECT_NEAR(off.chi2_after, after.solution->switched_off[0].chi2, 1e-6 * off.chi2_after);
  EXPECT_EQ(off.gate, after.solution->switched_off[0].gate);
  EXPECT_LT(off.chi2_before, 1e-6);
}

TEST(CompareSolutionsTest, ALinkPointOfOneSideHasNoResidualThere) {
  std::vector<LinkPoint> fewer = DoorsInARow();
  fewer.pop_back();
  const SolvedRow before = SolveRow(fewer);
  const SolvedRow after = SolveRow(DoorsInARow({0.1, 2, 0}));
  ASSERT_OK_AND_ASSIGN(const auto difference, CompareSolutions(before.with(), after.with(), {L("bc2"), L("none")}));
  ASSERT_EQ(difference.residuals.size(), 2U);
  EXPECT_EQ(difference.residuals[0].chi2_before, 0.0);
  EXPECT_GT(difference.residuals[0].chi2_after, 0.0);
  EXPECT_EQ(difference.residuals[1].gate, 0.0);
}

}  // namespace
}  // namespace enfilade::graph
