// SPDX-License-Identifier: Apache-2.0
#include "core/localization/pose_search.h"

#include <algorithm>

#include "gtest/gtest.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/core/localization/drawn_map.h"

namespace enfilade::localization {
namespace {

std::vector<Eigen::Vector2d> PointsAt(const DrawnMap& map, const Pose2& T_map_robot) {
  std::vector<Eigen::Vector2d> points = sensor::HitPoints(map.Scan(T_map_robot), 30.0);
  std::vector<Eigen::Vector2d> some;
  for (std::size_t i = 0; i < points.size(); i += 4) some.push_back(points[i]);
  return some;
}

bool IsNear(const Pose2& a, const Pose2& b) {
  const Pose2 off = Between(a, b);
  return off.translation().norm() < 0.15 && std::abs(off.yaw) < 0.06;
}

TEST(FindPosesTest, FindsAllPlacesThatFitTheBestFirst) {
  const DrawnMap room = SymmetricRoom();
  const Pose2 truth{2.0, 1.2, 0.5};
  const Pose2 turned{6.0 - truth.x, 3.5 - truth.y, truth.yaw - M_PI};
  ASSERT_OK_AND_ASSIGN(const FoundPoses found,
                       FindPoses(*room.Searchable(), PointsAt(room, truth), std::nullopt, LocalizationOptions(), GoOn));
  EXPECT_TRUE(found.complete);
  ASSERT_GE(found.poses.size(), 2U);
  for (const Pose2& wanted : {truth, turned}) {
    EXPECT_TRUE(IsNear(found.poses[0].T_map_robot, wanted) || IsNear(found.poses[1].T_map_robot, wanted));
  }
  for (std::size_t i = 1; i < found.poses.size(); ++i) EXPECT_GE(found.poses[i - 1].score, found.poses[i].score);
  EXPECT_GT(found.poses[0].score, 0.8);
}

TEST(FindPosesTest, LooksOnlyInTheArea) {
  const DrawnMap room = SymmetricRoom();
  const Pose2 truth{2.0, 1.2, 0.5};
  ASSERT_OK_AND_ASSIGN(const FoundPoses found, FindPoses(*room.Searchable(), PointsAt(room, truth),
                                                         SearchArea{{2.2, 1.0}, 0.6}, LocalizationOptions(), GoOn));
  ASSERT_FALSE(found.poses.empty());
  EXPECT_TRUE(IsNear(found.poses.front().T_map_robot, truth));
  for (const FoundPose& one : found.poses) {
    EXPECT_LT((one.T_map_robot.translation() - Eigen::Vector2d(2.2, 1.0)).cwiseAbs().maxCoeff(), 0.75);
  }
  ASSERT_OK_AND_ASSIGN(const FoundPoses outside, FindPoses(*room.Searchable(), PointsAt(room, truth),
                                                           SearchArea{{50.0, 1.0}, 0.6}, LocalizationOptions(), GoOn));
  EXPECT_TRUE(outside.poses.empty());
}

TEST(FindPosesTest, SaysThatItGaveUp) {
  const DrawnMap room = UniqueRoom();
  LocalizationOptions options;
  options.max_expansions = 10;
  ASSERT_OK_AND_ASSIGN(const FoundPoses found,
                       FindPoses(*room.Searchable(), PointsAt(room, {1.5, 2.5, 0.3}), std::nullopt, options, GoOn));
  EXPECT_FALSE(found.complete);
}

}  // namespace
}  // namespace enfilade::localization
