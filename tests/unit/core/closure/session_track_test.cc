// SPDX-License-Identifier: Apache-2.0
#include "core/closure/session_track.h"

#include "gmock/gmock.h"
#include "tests/support/pose_matchers.h"

namespace enfilade::closure {
namespace {

using ::enfilade::testing::PoseNear;

constexpr TimeNs kSecond = kNsPerSecond;

TEST(SessionTrack, CarriesTheNearestMappedPoseByOdometry) {
  // Odometry's frame is turned by 90 degrees against the map's.
  const SessionTrack track({{10 * kSecond, {5, 5, 0}}},
                           {{10 * kSecond, {0, 0, M_PI_2}}, {10 * kSecond + kSecond / 2, {0, 1, M_PI_2}}}, {});
  const auto pose = track.PoseAt(10 * kSecond + kSecond / 4);
  ASSERT_TRUE(pose.has_value());
  EXPECT_THAT(pose->pose, PoseNear(Pose2{5.5, 5, 0}, 1e-9, 1e-9));
  EXPECT_GT(pose->covariance(0, 0), 0.0);
  EXPECT_LT(pose->covariance(0, 0), 0.001);
}

TEST(SessionTrack, GivesWhatOdometrySeesInTheMap) {
  const SessionTrack track({{0, {1, 0, 0}}}, {{0, {10, 10, M_PI}}, {kSecond / 2, {9, 10, M_PI}}}, {});
  const auto door = track.ToMap({7, 10, M_PI_2}, kSecond / 2);
  ASSERT_TRUE(door.has_value());
  EXPECT_THAT(door->pose, PoseNear(Pose2{4, 0, -M_PI_2}, 1e-9, 1e-9));
}

// However far from the map's origin, and however unsure of where that is.
TEST(SessionTrack, TheWayFromADoorIsAsSureAsMatchingIs) {
  const SessionTrack track({{0, {100, 0, 0}}, {kSecond, {102, 0, 0}}}, {{0, {0, 0, 0}}, {kSecond, {2.3, 0.1, 0.05}}},
                           {});
  const auto way = track.RelativePose({0, 0, 0}, 0, kSecond);
  ASSERT_TRUE(way.has_value());
  EXPECT_THAT(way->pose, PoseNear(Pose2{2, 0, 0}, 1e-9, 1e-9));
  EXPECT_NEAR(way->covariance(0, 0), 2 * 0.02 * 0.02, 1e-9);
  EXPECT_NEAR(way->covariance(1, 1), 2 * 0.02 * 0.02 + 4 * 0.005 * 0.005, 1e-9);
  EXPECT_NEAR(way->covariance(2, 2), 2 * 0.005 * 0.005, 1e-9);
  EXPECT_FALSE(track.RelativePose({0, 0, 0}, 0, 60 * kSecond).has_value());
}

TEST(SessionTrack, WithoutOdometryTheNearestScanIsTheRobotsPose) {
  const SessionTrack track({{0, {1, 0, 0}}, {kSecond, {2, 0, 0}}}, {}, {});
  EXPECT_THAT(track.PoseAt(kSecond + kSecond / 5)->pose, PoseNear(Pose2{2, 0, 0}, 1e-9, 1e-9));
  EXPECT_THAT(track.ToMap({70, 1, 2}, kSecond)->pose, PoseNear(Pose2{2, 0, 0}, 1e-9, 1e-9));
  EXPECT_FALSE(track.PoseAt(3 * kSecond).has_value());
}

TEST(SessionTrack, SaysNothingOfTimesThatNothingWasMappedAt) {
  const SessionTrack nothing({}, {{0, {}}, {kSecond, {}}}, {});
  EXPECT_FALSE(nothing.PoseAt(0).has_value());
  EXPECT_FALSE(nothing.ToMap({}, 0).has_value());
  const SessionTrack early({{0, {}}}, {{0, {}}, {60 * kSecond, {}}}, {});
  EXPECT_FALSE(early.PoseAt(60 * kSecond).has_value());
  EXPECT_FALSE(early.OdometryAt(30 * kSecond).has_value());
}

TEST(SessionTrack, TakesSamplesInAnyOrder) {
  const SessionTrack track({{kSecond, {1, 0, 0}}, {0, {0, 0, 0}}}, {{kSecond, {1, 0, 0}}, {0, {0, 0, 0}}}, {});
  EXPECT_THAT(track.PoseAt(kSecond / 2)->pose, PoseNear(Pose2{0.5, 0, 0}, 1e-9, 1e-9));
}

}  // namespace
}  // namespace enfilade::closure
