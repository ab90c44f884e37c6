// SPDX-License-Identifier: Apache-2.0
#include "core/closure/joined_anchors.h"

#include "core/graph/paths/pose_chain.h"
#include "gmock/gmock.h"
#include "tests/support/pose_matchers.h"

namespace enfilade::closure {
namespace {

using ::enfilade::testing::PoseNear;

const MapId kHere("here");
const MapId kThere("there");

Eigen::Matrix3d Diagonal(double position, double yaw) { return Eigen::Vector3d(position, position, yaw).asDiagonal(); }

// A closure measures the orientation, too, and the registration's transform must not be inverted.
TEST(JoinedAnchors, TheChainAcrossTheDoorPutsTheRobotWhereRegistrationFoundIt) {
  const Pose2 T_here_robot{7, 3, 0.4};
  const PoseWithCovariance T_here_door{{6, 2.5, 0.5}, Diagonal(0.01, 0.001)};
  const PoseWithCovariance T_there_robot{{-2, 11, -2.2}, Diagonal(0.02, 0.002)};
  const JoinedAnchors joined = JoinAtDoor(kHere, T_here_robot, T_here_door, kThere, T_there_robot);
  EXPECT_EQ(joined.here.map, kHere);
  EXPECT_THAT(joined.here.T_map_place, PoseNear(T_here_door.pose, 1e-12, 1e-12));
  const PoseWithCovariance T_there_here = graph::TransformAcross(joined.there, joined.here);
  EXPECT_THAT(T_there_here.pose * T_here_robot, PoseNear(T_there_robot.pose, 1e-9, 1e-9));
  // The yaw has the variances of both sides.
  EXPECT_NEAR(T_there_here.covariance(2, 2), 0.003, 1e-12);
}

TEST(JoinedAnchors, AnErrorInYawMovesTheDoorAroundTheRobot) {
  const PoseWithCovariance T_there_robot{{0, 0, 0}, Diagonal(0.0, 0.01)};
  const JoinedAnchors joined =
      JoinAtDoor(kHere, {2, 0, 0}, {{0, 0, 0}, Eigen::Matrix3d::Zero()}, kThere, T_there_robot);
  EXPECT_NEAR(joined.there.covariance(1, 1), 4 * 0.01, 1e-12);
  EXPECT_NEAR(joined.there.covariance(0, 0), 0.0, 1e-12);
}

TEST(JoinedAnchors, TheRobotBehindAKnownDoorFollowsFromItsPoseBeforeIt) {
  graph::LinkPoint door;
  door.anchors = {{kHere, {4, 0, 0}, Diagonal(0.01, 0.001)}, {kThere, {0, 0, M_PI_2}, Diagonal(0.01, 0.001)}};
  const auto pose = PoseAcross(door, kHere, kThere, {{5, 0, 0}, Diagonal(0.01, 0.001)});
  ASSERT_TRUE(pose.has_value());
  EXPECT_THAT(pose->pose, PoseNear(Pose2{0, 1, M_PI_2}, 1e-9, 1e-9));
  EXPECT_GT(pose->covariance(0, 0), 0.03 - 1e-9);
  EXPECT_FALSE(PoseAcross(door, kHere, MapId("nowhere"), {}).has_value());
}

// The map behind is found by what the link point joins, not by numbers or order.
TEST(JoinedAnchors, ThePoseAcrossIsInTheRequestedMapWhateverTheOrderOfAnchors) {
  graph::LinkPoint lift;
  lift.id = LinkPointId("107");
  lift.anchors = {{MapId("9"), {100, 100, 1}, Diagonal(0.01, 0.001)},
                  {MapId("2"), {0, 0, M_PI_2}, Diagonal(0.01, 0.001)},
                  {MapId("3"), {-50, 7, 2}, Diagonal(0.01, 0.001)},
                  {MapId("11"), {4, 0, 0}, Diagonal(0.01, 0.001)}};
  const PoseWithCovariance robot{{5, 0, 0}, Diagonal(0.01, 0.001)};
  EXPECT_THAT(PoseAcross(lift, MapId("11"), MapId("2"), robot)->pose, PoseNear(Pose2{0, 1, M_PI_2}, 1e-9, 1e-9));
  EXPECT_FALSE(PoseAcross(lift, MapId("11"), MapId("12"), robot).has_value());
}

TEST(JoinedAnchors, ANewMapStartsAtTheDoor) {
  const graph::Anchor origin = OriginAnchor(kThere, {});
  EXPECT_EQ(origin.T_map_place, Pose2{});
  EXPECT_GT(origin.covariance(2, 2), 0.0);
  EXPECT_LT(origin.covariance(0, 0), 0.001);
}

TEST(JoinedAnchors, FindsTheLinkPointThatJoinsTheSameMapsAtTheSamePlace) {
  graph::LinkPoint door;
  door.id = LinkPointId("door");
  door.anchors = {{kHere, {4, 0, 0}, Diagonal(0.001, 0.001)}, {kThere, {0, 0, 0}, Diagonal(0.001, 0.001)}};
  const auto joined = [](double dx_here, double dx_there) {
    return JoinedAnchors{.here = {kHere, {4 + dx_here, 0, 0}, Diagonal(0.001, 0.001)},
                         .there = {kThere, {dx_there, 0, 0}, Diagonal(0.001, 0.001)}};
  };
  EXPECT_EQ(FindRedundant({&door}, joined(0.2, 0.2)), &door);
  EXPECT_EQ(FindRedundant({&door}, joined(0.2, 2.0)), nullptr);
  EXPECT_EQ(FindRedundant({&door}, joined(2.0, 0.2)), nullptr);
  door.use = graph::LinkPointUse::kSuspended;
  EXPECT_EQ(FindRedundant({&door}, joined(0.2, 0.2)), nullptr);
}

}  // namespace
}  // namespace enfilade::closure
