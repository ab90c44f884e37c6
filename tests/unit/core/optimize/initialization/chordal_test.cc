// SPDX-License-Identifier: Apache-2.0
#include "core/optimize/initialization/chordal.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/manhattan_graph.h"
#include "tests/support/pose_matchers.h"
#include "tests/support/status_assertions.h"

namespace enfilade::optimize {
namespace {

using testing::PoseNear;

class ChordalTest : public ::testing::Test {
 protected:
  // Nodes that are not held get random poses.
  std::vector<Pose2> PosesFromNonsense(testing::ManhattanGraph world, const std::vector<std::int64_t>& held) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> any(-3.0, 3.0);
    for (PoseGraphNode& node : world.graph.nodes) node.T_world_node = {any(random), any(random), any(random)};
    for (const std::int64_t id : held) world.graph.nodes[id].T_world_node = world.truth[id];
    const auto components = IndexComponents(world.graph, held);
    EXPECT_OK(components);
    const auto poses = ChordalPoses(components->front(), LayOut(components->front()));
    EXPECT_TRUE(poses.has_value());
    return poses.value_or(std::vector<Pose2>(world.truth.size()));
  }
};

TEST_F(ChordalTest, IsExactWithoutNoiseWhateverTheGivenPoses) {
  const testing::ManhattanGraph world =
      testing::MakeManhattanGraph({.nodes = 150, .sigma_xy = 1e-9, .sigma_yaw = 1e-9});
  for (const std::vector<std::int64_t>& held : {std::vector<std::int64_t>{3}, std::vector<std::int64_t>{0, 149, 70}}) {
    const std::vector<Pose2> poses = PosesFromNonsense(world, held);
    for (std::size_t i = 0; i < poses.size(); ++i) EXPECT_THAT(poses[i], PoseNear(world.truth[i], 1e-6, 1e-6));
  }
}

TEST_F(ChordalTest, IsNearTheTruthWithNoise) {
  const testing::ManhattanGraph world = testing::MakeManhattanGraph({.nodes = 400});
  const std::vector<Pose2> poses = PosesFromNonsense(world, {0});
  for (std::size_t i = 0; i < poses.size(); ++i) EXPECT_THAT(poses[i], PoseNear(world.truth[i], 1.5, 0.2));
}

}  // namespace
}  // namespace enfilade::optimize
