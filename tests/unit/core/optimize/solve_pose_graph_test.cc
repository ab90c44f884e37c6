// SPDX-License-Identifier: Apache-2.0
#include "core/optimize/solve_pose_graph.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/support/manhattan_graph.h"
#include "tests/support/pose_matchers.h"
#include "tests/support/status_assertions.h"

namespace enfilade::optimize {
namespace {

using ::testing::HasSubstr;
using testing::MakeManhattanGraph;
using testing::PoseNear;

// A square of side 1 driven once, whose odometry says 5 cm too much per side; the closing edge is right.
PoseGraph SquareLoop() {
  PoseGraph graph;
  Pose2 pose;
  for (int i = 0; i < 4; ++i) {
    graph.nodes.push_back({i, pose});
    pose = pose * Pose2{1.05, 0.0, M_PI / 2};
    if (i > 0) graph.edges.push_back({i - 1, i, {1.05, 0.0, M_PI / 2}});
  }
  graph.edges.push_back({3, 0, {1.0, 0.0, M_PI / 2}});
  return graph;
}

// A copy of the graph with shifted ids and poses.
void Append(const PoseGraph& graph, std::int64_t id_offset, double x_offset, PoseGraph& target) {
  for (PoseGraphNode node : graph.nodes) {
    node.id += id_offset;
    node.T_world_node.x += x_offset;
    target.nodes.push_back(node);
  }
  for (PoseGraphEdge edge : graph.edges) {
    edge.from += id_offset;
    edge.to += id_offset;
    target.edges.push_back(edge);
  }
}

// By symmetry, the two sides along x share their difference equally, and so do those along y (0).
TEST(SolvePoseGraph, DistributesTheErrorOfALoop) {
  PoseGraph graph = SquareLoop();
  ASSERT_OK_AND_ASSIGN(const SolveReport report, SolvePoseGraph({}, graph));
  EXPECT_TRUE(report.converged);
  EXPECT_EQ(report.components, 1);
  EXPECT_NEAR(report.initial_chi2, 0.05 * 0.05, 1e-12);
  EXPECT_LT(report.final_chi2, 0.5 * report.initial_chi2);
  EXPECT_EQ(report.final_cost, report.final_chi2);
  EXPECT_THAT(graph.nodes[0].T_world_node, PoseNear(Pose2{}, 0.0, 0.0));
}

TEST(SolvePoseGraph, SolvesNothingInAnEmptyGraph) {
  PoseGraph graph;
  ASSERT_OK_AND_ASSIGN(const SolveReport report, SolvePoseGraph({}, graph));
  EXPECT_TRUE(report.converged);
  EXPECT_EQ(report.components, 0);
}

TEST(SolvePoseGraph, SolvesComponentsAsIfEachWereAlone) {
  const PoseGraph part = MakeManhattanGraph({.nodes = 80}).graph;
  PoseGraph alone = part;
  ASSERT_OK_AND_ASSIGN(const SolveReport one, SolvePoseGraph({}, alone));
  PoseGraph both;
  Append(part, 0, 0.0, both);
  Append(part, 1000, 50.0, both);
  both.nodes.push_back({5000, {7.0, 7.0, 7.0}});
  ASSERT_OK_AND_ASSIGN(const SolveReport report, SolvePoseGraph({}, both));
  EXPECT_EQ(report.components, 3);
  EXPECT_TRUE(report.converged);
  EXPECT_NEAR(report.final_chi2, 2.0 * one.final_chi2, 1e-9 * one.final_chi2);
  for (int i = 0; i < 80; ++i) {
    const Pose2 T = alone.nodes[i].T_world_node;
    EXPECT_EQ(both.nodes[i].T_world_node, T);
    EXPECT_THAT(both.nodes[80 + i].T_world_node, PoseNear(Pose2{T.x + 50.0, T.y, T.yaw}, 1e-6, 1e-6));
  }
  EXPECT_EQ(both.nodes.back().T_world_node, (Pose2{7.0, 7.0, 7.0}));
}

TEST(SolvePoseGraph, HoldsTheNodesNamed) {
  PoseGraph graph = MakeManhattanGraph({.nodes = 80}).graph;
  const PoseGraph given = graph;
  ASSERT_OK(SolvePoseGraph({.fixed = {30, 60}}, graph));
  EXPECT_EQ(graph.nodes[30].T_world_node, given.nodes[30].T_world_node);
  EXPECT_EQ(graph.nodes[60].T_world_node, given.nodes[60].T_world_node);
  EXPECT_NE(graph.nodes[0].T_world_node, given.nodes[0].T_world_node);
}

TEST(SolvePoseGraph, LeavesAGraphWhoseNodesAreAllHeld) {
  PoseGraph graph = SquareLoop();
  const PoseGraph given = graph;
  ASSERT_OK_AND_ASSIGN(const SolveReport report, SolvePoseGraph({.fixed = {0, 1, 2, 3}}, graph));
  EXPECT_TRUE(report.converged);
  EXPECT_EQ(report.final_chi2, report.initial_chi2);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(graph.nodes[i].T_world_node, given.nodes[i].T_world_node);
}

TEST(SolvePoseGraph, ReportsADisabledEdgeButDoesNotObeyIt) {
  PoseGraph graph = SquareLoop();
  graph.edges.back().enabled = false;
  ASSERT_OK_AND_ASSIGN(const SolveReport report, SolvePoseGraph({}, graph));
  EXPECT_NEAR(report.final_chi2, 0.0, 1e-12);
  EXPECT_NEAR(report.edge_chi2.back(), 0.05 * 0.05, 1e-9);
  EXPECT_EQ(report.edge_weight.back(), 0.0);
  EXPECT_EQ(report.edge_weight.front(), 1.0);
}

TEST(SolvePoseGraph, ReportsTheChi2OfEveryEdge) {
  PoseGraph graph = MakeManhattanGraph({.nodes = 80}).graph;
  ASSERT_OK_AND_ASSIGN(const SolveReport report, SolvePoseGraph({}, graph));
  ASSERT_EQ(report.edge_chi2.size(), graph.edges.size());
  double sum = 0.0;
  for (const double chi2 : report.edge_chi2) sum += chi2;
  EXPECT_NEAR(sum, report.final_chi2, 1e-9 * sum);
}

TEST(SolvePoseGraph, GivesTheSameResultTwice) {
  PoseGraph first = MakeManhattanGraph({.nodes = 200}).graph;
  PoseGraph second = first;
  ASSERT_OK(SolvePoseGraph({}, first));
  ASSERT_OK(SolvePoseGraph({}, second));
  for (int i = 0; i < 200; ++i) EXPECT_EQ(first.nodes[i].T_world_node, second.nodes[i].T_world_node);
}

// As SLAM does: one node more, one solve more.
TEST(SolvePoseGraph, FollowsAGrowingGraphInAFewSteps) {
  const PoseGraph whole = MakeManhattanGraph({.nodes = 300}).graph;
  PoseGraph growing;
  for (int i = 0; i < 300; ++i) {
    growing.nodes.push_back(whole.nodes[i]);
    if (i > 0) growing.nodes[i].T_world_node = growing.nodes[i - 1].T_world_node * whole.edges[i - 1].T_from_to;
    for (const PoseGraphEdge& edge : whole.edges) {
      if (std::max(edge.from, edge.to) == i) growing.edges.push_back(edge);
    }
    if (i % 10 != 9) continue;
    ASSERT_OK_AND_ASSIGN(const SolveReport report, SolvePoseGraph({.initialisation = Initialisation::kNone}, growing));
    EXPECT_TRUE(report.converged);
    EXPECT_LE(report.iterations, 8) << "node " << i;
  }
  PoseGraph at_once = whole;
  ASSERT_OK_AND_ASSIGN(const SolveReport expected, SolvePoseGraph({}, at_once));
  ASSERT_OK_AND_ASSIGN(const SolveReport last, SolvePoseGraph({.initialisation = Initialisation::kNone}, growing));
  EXPECT_NEAR(last.final_chi2, expected.final_chi2, 1e-6 * expected.final_chi2);
}

class SolvePoseGraphRejects : public ::testing::Test {
 protected:
  void Expect(const char* what, const SolveOptions& options = {}) {
    const PoseGraph given = graph_;
    EXPECT_STATUS(SolvePoseGraph(options, graph_), absl::StatusCode::kInvalidArgument, HasSubstr(what));
    for (std::size_t i = 1; i < given.nodes.size(); ++i) {
      EXPECT_EQ(graph_.nodes[i].T_world_node, given.nodes[i].T_world_node);
    }
  }

  PoseGraph graph_ = SquareLoop();
};

TEST_F(SolvePoseGraphRejects, AnEdgeToAnAbsentNode) {
  graph_.edges.push_back({0, 9, {}});
  Expect("no node 9");
}
TEST_F(SolvePoseGraphRejects, AnEdgeToItself) {
  graph_.edges.push_back({2, 2, {}});
  Expect("edge 2 -> 2");
}
TEST_F(SolvePoseGraphRejects, TwoNodesOfOneId) {
  graph_.nodes.push_back({2, {}});
  Expect("node 2 appears twice");
}
TEST_F(SolvePoseGraphRejects, APoseThatIsNotFinite) {
  graph_.nodes[0].T_world_node.x = std::numeric_limits<double>::quiet_NaN();
  Expect("node 0");
}
TEST_F(SolvePoseGraphRejects, AMeasurementThatIsNotFinite) {
  graph_.edges[1].T_from_to.yaw = std::numeric_limits<double>::infinity();
  Expect("edge 1 -> 2");
}
TEST_F(SolvePoseGraphRejects, InformationThatIsNotPositiveDefinite) {
  graph_.edges[1].information(0, 0) = -1.0;
  Expect("not positive definite");
}
TEST_F(SolvePoseGraphRejects, InformationThatIsNotSymmetric) {
  graph_.edges[1].information(0, 1) = 0.5;
  Expect("not symmetric");
}
TEST_F(SolvePoseGraphRejects, AnUnknownFixedNode) { Expect("no node 4", {.fixed = {4}}); }
TEST_F(SolvePoseGraphRejects, AKernelWithoutWidth) { Expect("width", {.kernel = {RobustKernel::Type::kHuber, 0.0}}); }

}  // namespace
}  // namespace enfilade::optimize
