// SPDX-License-Identifier: Apache-2.0
#include "core/optimize/initialization/starts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "core/optimize/graph_layout.h"
#include "core/optimize/indexed_graph.h"
#include "core/optimize/linear/normal_equations.h"
#include "tests/support/manhattan_graph.h"
#include "tests/support/status_assertions.h"

namespace enfilade::optimize {
namespace {

// A circle whose measurements turn once around; given poses that turn twice are a minimum of their own.
PoseGraph Circle(int turns_of_guess) {
  PoseGraph graph;
  Pose2 pose;
  const int n = 20;
  for (int i = 0; i < n; ++i) {
    graph.nodes.push_back({i, pose});
    graph.edges.push_back({i, (i + 1) % n, {1.0, 0.0, 2.0 * M_PI / n}});
    pose = pose * Pose2{1.0, 0.0, turns_of_guess * 2.0 * M_PI / n};
  }
  return graph;
}

class StartsTest : public ::testing::Test {
 protected:
  Minimum FromGivenPoses(const PoseGraph& graph) { return Run(graph, false); }
  Minimum FromSeveralStarts(const PoseGraph& graph) { return Run(graph, true); }

  std::vector<Pose2> solution_;

 private:
  Minimum Run(const PoseGraph& graph, bool several) {
    const auto components = IndexComponents(graph, {});
    EXPECT_OK(components);
    IndexedGraph indexed = components->front();
    const GraphLayout layout = LayOut(indexed);
    const Minimum minimum =
        several ? MinimizeFromSeveralStarts(&Minimize, {}, layout, indexed) : Minimize({}, layout, indexed);
    solution_ = indexed.poses;
    EXPECT_NEAR(minimum.cost, GraphCost(indexed, indexed.poses, {}), 1e-9);
    return minimum;
  }
};

TEST_F(StartsTest, LeavesAMinimumThatTurnsTooOften) {
  EXPECT_GT(FromGivenPoses(Circle(2)).cost, 1.0);
  EXPECT_LT(FromSeveralStarts(Circle(2)).cost, 1e-9);
}

TEST_F(StartsTest, TakesTheGivenPosesWhenTheyAreRight) {
  const Minimum minimum = FromSeveralStarts(Circle(1));
  EXPECT_LT(minimum.cost, 1e-9);
  EXPECT_EQ(minimum.iterations, 1);
}

TEST_F(StartsTest, FindsTheTruthFromOdometryThatTurnedAway) {
  testing::ManhattanGraph world = testing::MakeManhattanGraph({.nodes = 500});
  for (int i = 0; i < 500; ++i) {  // a gyro drift of 3 degrees a step in the given poses only
    world.graph.nodes[i].T_world_node.yaw = WrapAngle(world.graph.nodes[i].T_world_node.yaw + 0.05 * i);
  }
  const double from_truth = [&] {
    PoseGraph graph = world.graph;
    for (int i = 0; i < 500; ++i) graph.nodes[i].T_world_node = world.truth[i];
    return FromGivenPoses(graph).cost;
  }();
  EXPECT_NEAR(FromSeveralStarts(world.graph).cost, from_truth, 1e-6 * from_truth);
}

// Poses of a robot whose gyro drifts by `drift` (rad per node), in a graph of right measurements.
PoseGraph WithDriftingPoses(std::uint32_t seed, double drift) {
  PoseGraph graph = testing::MakeManhattanGraph({.nodes = 150, .seed = seed}).graph;
  Pose2 pose;
  for (std::size_t i = 0; i < graph.nodes.size(); ++i) {
    graph.nodes[i].T_world_node = pose;
    pose = pose * Pose2{1.0, 0.0, drift};
  }
  return graph;
}

// The lowest of several minima is no higher than any one of them.
TEST_F(StartsTest, IsNeverWorseThanTheGivenPosesAlone) {
  for (std::uint32_t seed = 1; seed <= 6; ++seed) {
    for (const double drift : {0.02, 0.3, 1.0}) {
      const PoseGraph graph = WithDriftingPoses(seed, drift);
      EXPECT_LE(FromSeveralStarts(graph).cost, FromGivenPoses(graph).cost * (1.0 + 1e-6))
          << "seed " << seed << ", drift " << drift;
    }
  }
}

std::vector<double> widths_minimized;  // by RecordingMinimizer

Minimum RecordingMinimizer(const MinimizeOptions& options, const GraphLayout& layout, IndexedGraph& graph) {
  widths_minimized.push_back(options.kernel.width);
  return Minimize(options, layout, graph);
}

class GraduatedNonConvexity : public ::testing::TestWithParam<RobustKernel::Type> {
 protected:
  std::vector<double> WidthsFor(double width) {
    const auto components =
        IndexComponents(testing::MakeManhattanGraph({.nodes = 100, .outlier_share = 0.1}).graph, {});
    EXPECT_OK(components);
    IndexedGraph graph = components->front();
    widths_minimized.clear();
    minimum_ = MinimizeFromSeveralStarts(&RecordingMinimizer, {.kernel = {GetParam(), width}}, LayOut(graph), graph);
    cost_ = GraphCost(graph, graph.poses, {GetParam(), width});
    return widths_minimized;
  }

  Minimum minimum_;
  double cost_ = 0.0;
};

// Redescending kernels are narrowed from ten times the width; the others have one minimum for given turns.
TEST_P(GraduatedNonConvexity, EndsAtTheKernelsOwnWidth) {
  const std::vector<double> widths = WidthsFor(0.5);
  ASSERT_FALSE(widths.empty());
  EXPECT_EQ(widths.back(), 0.5);
  EXPECT_NEAR(minimum_.cost, cost_, 1e-9 * cost_) << "the cost is that of the kernel asked for";
  const bool redescends = GetParam() == RobustKernel::Type::kCauchy || GetParam() == RobustKernel::Type::kDcs;
  if (!redescends) {
    for (const double width : widths) EXPECT_EQ(width, 0.5);
    return;
  }
  ASSERT_GE(widths.size(), 3U);
  EXPECT_EQ(widths.front(), 5.0);
  EXPECT_TRUE(std::is_sorted(widths.rbegin(), widths.rend())) << "never wider again";
}

INSTANTIATE_TEST_SUITE_P(Kernels, GraduatedNonConvexity,
                         ::testing::Values(RobustKernel::Type::kNone, RobustKernel::Type::kHuber,
                                           RobustKernel::Type::kCauchy, RobustKernel::Type::kDcs));

}  // namespace
}  // namespace enfilade::optimize
