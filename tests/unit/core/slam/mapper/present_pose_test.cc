// SPDX-License-Identifier: Apache-2.0
#include "core/slam/mapper/present_pose.h"

#include <gtest/gtest.h>

#include "core/slam/loops/slam_graph.h"
#include "tests/support/pose_matchers.h"
#include "tests/unit/core/slam/chain_of_submaps.h"

namespace enfilade::slam {
namespace {

using testing::PoseNear;

// The robot is 0.5 m beyond the last keyframe of a chain.
class FindPresentPoseTest : public ::testing::Test {
 protected:
  FindPresentPoseTest() {
    state_.track = Track{};
    state_.track->T_submap_robot = {1.5, 0.0, 0.3};
    state_.track->time = 1234;
  }

  std::optional<PresentPose> Find() const { return FindPresentPose(state_, {.lost_after = 3}); }

  static constexpr double kSigma = 0.1;  // of each step between submaps, m
  MapperState state_ =
      testing::MakeSubmapChain({.submaps = 4, .T_submap_next = {5.0, 0.0, 0.0}, .sigma = 0.1, .yaw_sigma = 1e-6});
};

TEST_F(FindPresentPoseTest, IsEmptyBeforeTheFirstScan) {
  EXPECT_EQ(FindPresentPose(MapperState{}, {}), std::nullopt);
  state_.track.reset();
  EXPECT_EQ(Find(), std::nullopt);
}

TEST_F(FindPresentPoseTest, IsThePoseInTheMapAtTheTimeOfTheScan) {
  const auto present = Find();
  ASSERT_TRUE(present.has_value());
  EXPECT_EQ(present->time, 1234);
  EXPECT_THAT(present->T_map_robot.pose, PoseNear(Pose2{15.0 + 1.5, 0.0, 0.3}, 1e-9, 1e-9));
  EXPECT_FALSE(present->lost);
}

TEST_F(FindPresentPoseTest, MovesWithTheLastKeyframe) {
  state_.nodes.at(3).T_map_node = {16.0, 2.0, 0.1};  // a closure has moved it against its submap
  EXPECT_THAT(Find()->T_map_robot.pose, PoseNear(Pose2{16.0, 2.0, 0.1} * Pose2{0.5, 0.0, 0.3}, 1e-9, 1e-9));
}

// Without a solution: three steps of 0.1 m, and the match in the last submap (0.01 m).
TEST_F(FindPresentPoseTest, AddsTheStepsSinceTheFirstSubmap) {
  const Eigen::Matrix3d covariance = Find()->T_map_robot.covariance;
  EXPECT_NEAR(covariance(0, 0), 3.0 * kSigma * kSigma + 0.0001, 1e-6);
}

// From a keyframe of submap 1 whose covariance the graph has given: two steps more.
TEST_F(FindPresentPoseTest, StartsFromTheLastSolvedKeyframe) {
  state_.nodes_at_solve = 2;
  state_.nodes.at(1).covariance = Eigen::Vector3d(0.5, 0.25, 1e-8).asDiagonal();
  const Eigen::Matrix3d covariance = Find()->T_map_robot.covariance;
  EXPECT_NEAR(covariance(0, 0), 0.5 + 2.0 * kSigma * kSigma + 0.0001, 1e-5);
  EXPECT_NEAR(covariance(1, 1), 0.25 + 2.0 * kSigma * kSigma + 0.0001, 1e-5);
}

TEST_F(FindPresentPoseTest, AgreesWithTheGraphRightAfterASolution) {
  SolveSlamGraph({}, state_);
  state_.nodes_at_solve = 4;
  state_.track->T_submap_robot = state_.finished.at(3).nodes.front().T_submap_node;  // on the keyframe
  const auto present = Find();
  const SlamNode& last = state_.nodes.at(3);
  EXPECT_THAT(present->T_map_robot.pose, PoseNear(last.T_map_node, 1e-9, 1e-9));
  EXPECT_NEAR(present->T_map_robot.covariance(0, 0), last.covariance(0, 0), 0.05 * last.covariance(0, 0));
}

TEST_F(FindPresentPoseTest, SaysWhetherTheRobotIsLost) {
  state_.track->quality.poor = 2;
  EXPECT_FALSE(Find()->lost);
  state_.track->quality.poor = 3;
  EXPECT_TRUE(Find()->lost);
  state_.track->quality.poor = 0;
  state_.adrift_since = 2;
  EXPECT_TRUE(Find()->lost) << "not recognised since it was lost";
}

}  // namespace
}  // namespace enfilade::slam
