// SPDX-License-Identifier: Apache-2.0
#include "core/slam/slam_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/pose_matchers.h"

namespace enfilade::slam {
namespace {

using ::testing::ElementsAre;
using testing::PoseNear;

SlamNode NodeRow(std::int64_t id, const Pose2& T_map_node) {
  SlamNode node;
  node.id = id;
  node.T_map_node = T_map_node;
  return node;
}

TEST(SlamDelta, IsEmptyOnlyWithoutAnyRow) {
  EXPECT_TRUE(SlamDelta{}.empty());
  SlamDelta nodes, submaps, loop_closures, trajectory;
  nodes.nodes.emplace_back();
  submaps.submaps.emplace_back();
  loop_closures.loop_closures.emplace_back();
  trajectory.trajectory.emplace_back();
  for (const SlamDelta* delta : {&nodes, &submaps, &loop_closures, &trajectory}) EXPECT_FALSE(delta->empty());
}

TEST(SlamMap, ReplacesRowsAsAWhole) {
  SlamMap map;
  SlamDelta first;
  first.nodes = {NodeRow(0, {1.0, 0.0, 0.0}), NodeRow(1, {2.0, 0.0, 0.0})};
  first.loop_closures.resize(1);
  first.loop_closures[0].reason = "not seen";
  map.Apply(first);
  SlamDelta second;
  second.nodes = {NodeRow(1, {2.5, 0.0, 0.0})};
  second.loop_closures.resize(1);
  second.loop_closures[0].state = LoopClosureState::kAccepted;
  map.Apply(second);
  ASSERT_EQ(map.nodes.size(), 2U);
  EXPECT_EQ(map.nodes.at(0), first.nodes[0]);
  EXPECT_EQ(map.nodes.at(1), second.nodes[0]);
  EXPECT_EQ(map.loop_closures.at(0), second.loop_closures[0]) << "the reason, too";
}

TEST(SlamMap, KeepsASubmapsContentIfTheRowHasNone) {
  SlamMap map;
  map.Apply({{}, {{4, 1, {}, false, ""}}, {}, {}});
  EXPECT_EQ(map.submaps.at(4).content, "");
  map.Apply({{}, {{4, 2, {}, true, "grid"}}, {}, {}});
  map.Apply({{}, {{4, 3, {1.0, 2.0, 3.0}, true, ""}}, {}, {}});
  EXPECT_EQ(map.submaps.at(4), (SlamSubmap{4, 3, {1.0, 2.0, 3.0}, true, "grid"}));
  map.Apply({{}, {{4, 4, {}, true, "new grid"}}, {}, {}});
  EXPECT_EQ(map.submaps.at(4).content, "new grid");
}

TEST(SlamMap, AppendsToTheTrajectory) {
  SlamMap map;
  const TrajectoryPoint a{1, 10, 0, {}};
  const TrajectoryPoint b{2, 20, 0, {}};
  map.Apply({{}, {}, {}, {a}});
  map.Apply({});
  map.Apply({{}, {}, {}, {b}});
  EXPECT_THAT(map.trajectory, ElementsAre(a, b));
}

TEST(TrajectoryOf, FollowsItsNodesWhenTheyMove) {
  SlamMap map;
  map.nodes[0] = NodeRow(0, {1.0, 2.0, 0.0});
  map.nodes[1] = NodeRow(1, {5.0, 2.0, M_PI / 2.0});
  map.trajectory = {{1, 10, 0, {0.5, 0.0, 0.1}}, {2, 20, 1, {0.5, 0.0, 0.0}}};
  const auto before = TrajectoryOf(map);
  ASSERT_EQ(before.size(), 2U);
  EXPECT_EQ(before[0].time, 10);
  EXPECT_THAT(before[0].T_map_robot, PoseNear(Pose2{1.5, 2.0, 0.1}, 1e-12, 1e-12));
  EXPECT_THAT(before[1].T_map_robot, PoseNear(Pose2{5.0, 2.5, M_PI / 2.0}, 1e-12, 1e-12));
  map.nodes.at(1).T_map_node = {5.0, 3.0, M_PI};
  EXPECT_THAT(TrajectoryOf(map)[1].T_map_robot, PoseNear(Pose2{4.5, 3.0, M_PI}, 1e-12, 1e-12));
}

}  // namespace
}  // namespace enfilade::slam
