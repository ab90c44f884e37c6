// SPDX-License-Identifier: Apache-2.0
#include "core/slam/state/existing_map.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "core/slam/matching/motion_model.h"
#include "tests/support/pose_matchers.h"

namespace enfilade::slam {
namespace {

using testing::PoseNear;

// Known better ahead than to the side of its heading of 30 degrees.
ExistingMapEntry SomeEntry() {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  R.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(M_PI / 6.0).toRotationMatrix();
  const Eigen::Matrix3d own = Eigen::Vector3d(0.04, 0.25, 0.01).asDiagonal();
  return {{{3.0, -2.0, M_PI / 6.0}, R * own * R.transpose()}, Pose2{10.0, 5.0, 1.0}};
}

TEST(ReachOfEntry, IsThreeSigmaInTheLeastCertainDirection) {
  const EntryReach reach = ReachOf(SomeEntry());
  EXPECT_NEAR(reach.translation, 3.0 * 0.5, 1e-9);
  EXPECT_NEAR(reach.yaw, 3.0 * 0.1, 1e-9);
  const EntryReach certain = ReachOf({});
  EXPECT_EQ(certain.translation, 0.0);
  EXPECT_EQ(certain.yaw, 0.0);
}

TEST(PoseAtScanOfEntry, IsTheEntryWithTheFloorOfMatchingIfOdometryIsMissing) {
  const SlamOptions options;
  ExistingMapEntry entry = SomeEntry();
  const auto check = [&](const std::optional<Pose2>& T_odom_now) {
    const PoseWithCovariance pose = PoseAtScan(entry, T_odom_now, options);
    EXPECT_EQ(pose.pose, entry.T_map_robot.pose);
    Eigen::Matrix3d expected = entry.T_map_robot.covariance;
    expected.diagonal() += Eigen::Vector3d(0.02 * 0.02, 0.02 * 0.02, 0.005 * 0.005);
    EXPECT_LT((pose.covariance - expected).norm(), 1e-12);
  };
  check(std::nullopt);
  entry.T_odom_robot.reset();
  check(Pose2{11.0, 5.0, 1.0});
}

TEST(PoseAtScanOfEntry, MovesOnByOdometryAndBecomesLessCertain) {
  const ExistingMapEntry entry = SomeEntry();
  const Pose2 step{2.0, 0.5, 0.4};
  const PoseWithCovariance pose = PoseAtScan(entry, *entry.T_odom_robot * step, {});
  EXPECT_THAT(pose.pose, PoseNear(entry.T_map_robot.pose * step, 1e-9, 1e-9));
  EXPECT_GT(pose.covariance(2, 2), entry.T_map_robot.covariance(2, 2));
  const auto position_variance = [](const Eigen::Matrix3d& covariance) { return covariance(0, 0) + covariance(1, 1); };
  EXPECT_GT(position_variance(pose.covariance), position_variance(entry.T_map_robot.covariance));
  EXPECT_LT((pose.covariance - pose.covariance.transpose()).norm(), 1e-12);
  EXPECT_EQ(Eigen::LLT<Eigen::Matrix3d>(pose.covariance).info(), Eigen::Success);
}

TEST(PoseAtScanOfEntry, IsPositiveDefiniteForAnEntryWithoutUncertainty) {
  const PoseWithCovariance pose = PoseAtScan({}, std::nullopt, {});
  EXPECT_EQ(Eigen::LLT<Eigen::Matrix3d>(pose.covariance).info(), Eigen::Success);
}

TEST(ContentOfExistingMap, HasItsWallsAtTheCentresOfTheirCells) {
  grid::OccupancyGrid grid;
  grid.geometry.resolution = 0.05;
  grid.geometry.width = 3;
  grid.geometry.height = 1;
  grid.geometry.T_map_grid = {1.0, -0.5, 0.0};
  grid.cells = {grid::CellFromProbability(0.1), grid::CellFromProbability(0.95), grid::kUnknownCell};
  const SubmapContent content = ContentOf(grid, {});
  EXPECT_TRUE(content.nodes.empty());
  EXPECT_FALSE(content.next.has_value());
  const auto walls = content.grid.OccupiedPoints();
  ASSERT_EQ(walls.size(), 1U);
  EXPECT_LT((walls[0] - Eigen::Vector2d(1.075, -0.475)).norm(), 1e-9);
  const auto value_at = [&](double x) {
    const grid::LogOddsGrid& cells = content.grid.log_odds();
    return cells.ValueAt(cells.CellOf({x, -0.475}));
  };
  EXPECT_LT(value_at(1.025), 0);
  EXPECT_EQ(value_at(1.125), grid::LogOddsGrid::kUnknown);
}

TEST(ContentOfExistingMap, OfNoCellsIsAnEmptyGridOfTheOptionsResolution) {
  SlamOptions options;
  options.resolution = 0.1;
  const SubmapContent content = ContentOf({}, options);
  EXPECT_EQ(content.grid.resolution(), 0.1);
  EXPECT_TRUE(content.grid.OccupiedPoints().empty());
}

}  // namespace
}  // namespace enfilade::slam
