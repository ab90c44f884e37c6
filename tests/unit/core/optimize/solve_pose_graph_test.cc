#include "core/optimize/solve_pose_graph.h"

#include <gtest/gtest.h>

#include "tests/support/pose_matchers.h"
#include "tests/support/status_matchers.h"

namespace enfilade {
namespace {

using testing::HasStatus;
using ::testing::HasSubstr;
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

TEST(SolvePoseGraph, DistributesTheErrorOfALoop) {
  PoseGraph graph = SquareLoop();
  ASSERT_OK_AND_ASSIGN(const SolveReport report, SolvePoseGraph({}, graph));
  EXPECT_TRUE(report.converged);
  EXPECT_EQ(report.components, 1);
  EXPECT_LT(report.final_chi2, 0.6 * report.initial_chi2);
  EXPECT_THAT(graph.nodes[0].T_world_node, PoseNear(Pose2{}, 0.0, 0.0));
}

TEST(SolvePoseGraph, SolvesNothingInAnEmptyGraph) {
  PoseGraph graph;
  ASSERT_OK_AND_ASSIGN(const SolveReport report, SolvePoseGraph({}, graph));
  EXPECT_TRUE(report.converged);
  EXPECT_EQ(report.components, 0);
}

TEST(SolvePoseGraph, RejectsAnEdgeToAnAbsentNode) {
  PoseGraph graph = SquareLoop();
  graph.edges.push_back({0, 9, {}});
  EXPECT_THAT(SolvePoseGraph({}, graph), HasStatus(absl::StatusCode::kInvalidArgument, HasSubstr("no node 9")));
}

}  // namespace
}  // namespace enfilade
