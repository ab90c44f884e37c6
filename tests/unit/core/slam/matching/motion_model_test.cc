// SPDX-License-Identifier: Apache-2.0
#include "core/slam/matching/motion_model.h"

#include <gtest/gtest.h>

#include "tests/support/pose_matchers.h"

namespace enfilade::slam {
namespace {

using testing::PoseNear;

const MotionOptions kOptions;

TEST(PredictMotion, FollowsTheOdometryWithAnErrorThatGrowsWithWayAndTurn) {
  const Pose2 last{5.0, 5.0, 1.0};
  const PredictedMotion still = PredictMotion(last, last, {}, 1.0, kOptions);
  EXPECT_TRUE(still.by_odometry);
  EXPECT_DOUBLE_EQ(still.sigma_translation, kOptions.translation_floor);
  EXPECT_DOUBLE_EQ(still.sigma_yaw, kOptions.yaw_floor);
  const Pose2 step{1.0, 0.2, 0.5};
  const PredictedMotion moved = PredictMotion(last, last * step, {}, 1.0, kOptions);
  EXPECT_THAT(moved.T_last_now, PoseNear(step, 1e-12, 1e-12));
  EXPECT_GT(moved.sigma_translation, still.sigma_translation + 0.1 * kOptions.translation_per_metre);
  EXPECT_GT(moved.sigma_yaw, still.sigma_yaw + 0.4 * kOptions.yaw_per_radian);
}

TEST(PredictMotion, DoesNotBelieveAJumpOfTheOdometry) {
  const Step before{{0.3, 0.0, 0.1}, 1.0};
  const PredictedMotion motion = PredictMotion(Pose2{}, Pose2{1'000.0, 0.0, 0.0}, before, 1.0, kOptions);
  EXPECT_FALSE(motion.by_odometry);
  EXPECT_THAT(motion.T_last_now, PoseNear(before.T_from_to, 1e-12, 1e-12));
}

TEST(PredictMotion, GoesOnAsFastAsBeforeWithoutOdometry) {
  const Step before{{0.4, 0.0, 0.2}, 1.0};
  const auto after = [&](double seconds) { return PredictMotion({}, {}, before, seconds, kOptions).T_last_now; };
  EXPECT_THAT(after(1.0), PoseNear(Pose2{0.4, 0.0, 0.2}, 1e-12, 1e-12));
  EXPECT_THAT(after(0.5), PoseNear(Pose2{0.2, 0.0, 0.1}, 1e-12, 1e-12));
  EXPECT_THAT(after(60.0), PoseNear(Pose2{0.8, 0.0, 0.4}, 1e-12, 1e-12)) << "no farther than twice the step before";
  EXPECT_THAT(after(0.0), PoseNear(Pose2{}, 1e-12, 1e-12));
}

TEST(PredictMotion, TakesTheStepAsItWasWhereTimesSayNothing) {
  const Step before{{0.4, 0.0, 0.2}, 0.0};  // two scans of one time
  EXPECT_THAT(PredictMotion({}, {}, before, 1.0, kOptions).T_last_now, PoseNear(before.T_from_to, 1e-12, 1e-12));
  EXPECT_THAT(PredictMotion({}, {}, {}, 1.0, kOptions).T_last_now, PoseNear(Pose2{}, 1e-12, 1e-12));
}

}  // namespace
}  // namespace enfilade::slam
