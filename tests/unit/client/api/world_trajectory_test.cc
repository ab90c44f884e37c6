// SPDX-License-Identifier: Apache-2.0
#include "client/sdk/api/world_trajectory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/pose_matchers.h"

namespace enfilade::client {
namespace {

using ::testing::SizeIs;

MappedStretch Stretch(const std::string& session, std::optional<Pose2> T_world_map, std::vector<MappedPose> poses) {
  return {"sites/s/sessions/" + session, "sites/s/maps/of-" + session, "Of " + session, T_world_map, std::move(poses)};
}

TEST(JoinStretches, PutsEveryMapsPosesIntoTheWorldByTime) {
  const WorldTrajectory joined = JoinStretches({Stretch("a", Pose2{}, {{1, {1.0, 0.0, 0.0}}, {2, {2.0, 0.0, 0.0}}}),
                                                Stretch("b", Pose2{2.0, 5.0, M_PI / 2.0}, {{3, {1.0, 0.0, 0.5}}})});
  ASSERT_THAT(joined.poses, SizeIs(3));
  EXPECT_EQ(joined.poses[2].time, 3);
  EXPECT_THAT(joined.poses[1].T_world_robot, testing::PoseNear(Pose2{2.0, 0.0, 0.0}, 1e-12, 1e-12));
  EXPECT_THAT(joined.poses[2].T_world_robot, testing::PoseNear(Pose2{2.0, 6.0, M_PI / 2.0 + 0.5}, 1e-12, 1e-12));
  EXPECT_THAT(joined.left_out, SizeIs(0));
}

// At a door both sessions may have mapped the same scan.
TEST(JoinStretches, KeepsOnePoseForEachTime) {
  const WorldTrajectory joined = JoinStretches({Stretch("a", Pose2{}, {{1, {}}, {2, {0.1, 0.0, 0.0}}, {4, {}}}),
                                                Stretch("b", Pose2{}, {{2, {0.2, 0.0, 0.0}}, {3, {}}})});
  ASSERT_THAT(joined.poses, SizeIs(4));
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(joined.poses[i].time, static_cast<TimeNs>(i) + 1);
  EXPECT_DOUBLE_EQ(joined.poses[1].T_world_robot.x, 0.1) << "of the earlier session";
}

TEST(JoinStretches, LeavesOutWhatHasNoPlaceInTheWorld) {
  const WorldTrajectory joined =
      JoinStretches({Stretch("a", std::nullopt, {{1, {}}}), Stretch("b", Pose2{}, {{2, {}}})});
  EXPECT_THAT(joined.poses, SizeIs(1));
  ASSERT_THAT(joined.left_out, SizeIs(1));
  EXPECT_EQ(joined.left_out[0].map_name, "Of a");
}

}  // namespace
}  // namespace enfilade::client
