// SPDX-License-Identifier: Apache-2.0
#include "core/slam/mapper/locate_scan.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/slam/submaps/robot_rays.h"
#include "tests/support/pose_matchers.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/core/slam/synthetic_drive.h"

namespace enfilade::slam {
namespace {

using testing::PoseNear;

constexpr TimeNs kStart = 1'700'000'000 * kNsPerSecond;

// The robot stands in a room that the active submap knows, and takes its next scan half a second later.
class LocateScanTest : public ::testing::Test {
 protected:
  static constexpr Pose2 kLast{4.0, 3.0, 0.2};
  static constexpr Pose2 kStep{0.3, 0.05, 0.1};

  LocateScanTest() {
    for (const Pose2& pose : {kLast, Pose2{6.5, 2.0, 1.0}, Pose2{2.0, 2.0, -2.0}}) {
      EXPECT_OK(grid_.Insert(pose, RobotRays(Seen(pose), {})));
    }
    fields_.Rebuild(grid_);
    last_.T_submap_robot = kLast;
    last_.T_odom_robot = Pose2{};
    last_.time = last_.matched_at = kStart;
    last_.length_since_keyframe = 1.0;
  }

  sensor::LaserScan Seen(const Pose2& pose) const {
    return testing::Scan(walls_, pose, {.beams = 360, .field_of_view = 6.28}, kStart + kNsPerSecond / 2, 4);
  }

  static sensor::LaserScan EmptyScan() {
    sensor::LaserScan scan;
    scan.time = kStart + kNsPerSecond / 2;
    return scan;
  }

  LocatedScan Locate(const sensor::LaserScan& scan, const std::optional<Pose2>& T_odom_robot) const {
    const sensor::PairedScan paired{1, scan, T_odom_robot};
    return LocateScan(last_, paired, RobotRays(scan, {}), {grid_, fields_}, options_);
  }

  const std::vector<testing::Wall> walls_ = testing::WallsFromText({"#########",  //
                                                                    "#  #    #",  //
                                                                    "#      ##",  //
                                                                    "#       #",  //
                                                                    "##      #",  //
                                                                    "#########"},
                                                                   1.0);
  SlamOptions options_;
  SubmapGrid grid_{0.05, {}};
  LocalFields fields_{0.05, {}};
  Track last_;
};

TEST_F(LocateScanTest, TheFirstScanIsAtTheOriginByDefinition) {
  const sensor::PairedScan scan{1, Seen(kLast), Pose2{7.0, 8.0, 0.9}};
  const LocatedScan located = LocateFirstScan(scan);
  EXPECT_EQ(located.track.T_submap_robot, Pose2{});
  EXPECT_EQ(located.track.T_odom_robot, scan.T_odom_robot);
  EXPECT_EQ(located.track.time, scan.scan.time);
  EXPECT_EQ(located.track.matched_at, scan.scan.time);
  EXPECT_FALSE(located.track.last_step.has_value());
  EXPECT_TRUE(located.may_insert);
  EXPECT_LT(located.information.inverse().norm(), 1e-5);
}

TEST_F(LocateScanTest, CorrectsTheOdometryByTheScan) {
  const Pose2 truth = kLast * kStep;
  const LocatedScan located = Locate(Seen(truth), kStep * Pose2{0.05, -0.04, 0.04});
  EXPECT_THAT(located.track.T_submap_robot, PoseNear(truth, 0.02, 0.01));
  EXPECT_EQ(located.track.matched_at, located.track.time);
  EXPECT_EQ(located.track.time, kStart + kNsPerSecond / 2);
  EXPECT_EQ(located.track.quality, TrackQuality{});
  EXPECT_TRUE(located.may_insert);
  EXPECT_GT(located.matched_share, 0.9);
  // The information is that of the motion and of the match together.
  const PredictedMotion motion = PredictMotion(Pose2{}, kStep, {}, 0.5, options_.motion);
  EXPECT_GT(located.information(0, 0), InformationOf(motion.sigma_translation, motion.sigma_yaw)(0, 0));
}

TEST_F(LocateScanTest, RemembersTheStepAndItsLength) {
  const LocatedScan located = Locate(Seen(kLast * kStep), kStep);
  ASSERT_TRUE(located.track.last_step.has_value());
  EXPECT_DOUBLE_EQ(located.track.last_step->seconds, 0.5);
  EXPECT_THAT(located.track.last_step->T_from_to, PoseNear(Between(kLast, located.track.T_submap_robot), 1e-12, 1e-12));
  EXPECT_DOUBLE_EQ(located.track.length_since_keyframe, 1.0 + located.track.last_step->T_from_to.translation().norm());
  EXPECT_EQ(located.track.T_odom_robot, kStep);
}

TEST_F(LocateScanTest, FollowsTheOdometryIfTheScanIsEmpty) {
  const LocatedScan located = Locate(EmptyScan(), kStep);
  EXPECT_THAT(located.track.T_submap_robot, PoseNear(kLast * kStep, 1e-12, 1e-12));
  EXPECT_EQ(located.track.matched_at, kStart) << "no new match";
  EXPECT_EQ(located.track.quality.poor, 1);
  EXPECT_EQ(located.track.quality.contradicting, 0);
  EXPECT_TRUE(located.may_insert);
  const PredictedMotion motion = PredictMotion(Pose2{}, kStep, {}, 0.5, options_.motion);
  EXPECT_EQ(located.information, InformationOf(motion.sigma_translation, motion.sigma_yaw));
}

TEST_F(LocateScanTest, FollowsTheOdometryExactlyWithoutMatching) {
  options_.match_scans = false;
  const Pose2 by_odometry = kStep * Pose2{0.2, 0.2, 0.2};
  const LocatedScan located = Locate(Seen(kLast * kStep), by_odometry);
  EXPECT_THAT(located.track.T_submap_robot, PoseNear(kLast * by_odometry, 1e-12, 1e-12));
  EXPECT_EQ(located.matched_share, 0.0);
  EXPECT_EQ(located.track.quality, TrackQuality{});
}

// Wheels slip on the spot, or the odometry jumps: the scan says where the robot is.
TEST_F(LocateScanTest, BelievesTheScanIfTheOdometryLeadsToNoMatch) {
  last_.last_step = Step{kStep, 0.5};
  const Pose2 truth = kLast * kStep;
  for (const Pose2& jump : {Pose2{1.5, 1.0, 1.2}, Pose2{-9.0, 4.0, 2.0}, Pose2{500.0, 0.0, 0.0}}) {
    const LocatedScan located = Locate(Seen(truth), jump);
    EXPECT_THAT(located.track.T_submap_robot, PoseNear(truth, 0.03, 0.02)) << jump.x;
    EXPECT_EQ(located.track.quality.poor, 0);
    EXPECT_EQ(located.track.T_odom_robot, jump) << "the next step is measured from here";
  }
}

TEST_F(LocateScanTest, AssumesConstantVelocityWithoutOdometry) {
  last_.T_odom_robot.reset();
  last_.last_step = Step{kStep, 0.5};
  const Pose2 truth = kLast * kStep;
  EXPECT_THAT(Locate(Seen(truth), std::nullopt).track.T_submap_robot, PoseNear(truth, 0.03, 0.02));
  EXPECT_THAT(Locate(EmptyScan(), std::nullopt).track.T_submap_robot, PoseNear(truth, 1e-12, 1e-12));
}

TEST_F(LocateScanTest, KeepsAScanThatContradictsTheMapOut) {
  const std::vector<testing::Wall> closet = testing::WallsFromText({"###",  //
                                                                    "# #",  //
                                                                    "###"},
                                                                   1.0);
  const sensor::LaserScan scan =
      testing::Scan(closet, {1.5, 1.5, 0.0}, {.beams = 360, .field_of_view = 6.28}, kStart + kNsPerSecond / 2, 4);
  options_.local.max_half_width = 0.2;  // too narrow to find a wall that the closet's may be taken for
  const LocatedScan located = Locate(scan, kStep);
  EXPECT_FALSE(located.may_insert);
  EXPECT_EQ(located.track.quality.poor, 1);
  EXPECT_EQ(located.track.quality.contradicting, 1);
  EXPECT_THAT(located.track.T_submap_robot, PoseNear(kLast * kStep, 1e-12, 1e-12)) << "by the odometry alone";
}

// The robot enters a map at kLast, and its first scan is one step further.
class LocateAtEntryTest : public LocateScanTest {
 protected:
  LocateAtEntryTest() {
    entry_.T_map_robot = {kEntry, Eigen::Vector3d(0.0004, 0.0004, 0.0001).asDiagonal()};
    entry_.T_odom_robot = kOdom;
    entry_.seen = RobotRays(Seen(kLast), {});
  }

  PoseWithCovariance LocateFirst(const sensor::LaserScan& scan, const Pose2& T_odom_robot) const {
    return LocateAtEntry(entry_, {1, scan, T_odom_robot}, RobotRays(scan, {}), options_);
  }

  static constexpr Pose2 kEntry{-2.0, 7.0, 2.5};
  static constexpr Pose2 kOdom{11.0, 4.0, -1.0};
  ExistingMapEntry entry_;
};

TEST_F(LocateAtEntryTest, CorrectsTheOdometryByWhatWasSeenThere) {
  const Pose2 T_odom_now = kOdom * kStep * Pose2{0.03, -0.02, 0.03};
  const PoseWithCovariance first = LocateFirst(Seen(kLast * kStep), T_odom_now);
  EXPECT_THAT(first.pose, PoseNear(kEntry * kStep, 0.02, 0.008));
  const PoseWithCovariance by_odometry = PoseAtScan(entry_, T_odom_now, options_);
  EXPECT_LT(first.covariance(2, 2), by_odometry.covariance(2, 2));
  EXPECT_GE(first.covariance(2, 2), entry_.T_map_robot.covariance(2, 2));
}

TEST_F(LocateAtEntryTest, GoesByOdometryIfNothingWasSeenOrTheScanShowsNothing) {
  const Pose2 T_odom_now = kOdom * kStep;
  const PoseWithCovariance by_odometry = PoseAtScan(entry_, T_odom_now, options_);
  EXPECT_EQ(LocateFirst(EmptyScan(), T_odom_now).pose, by_odometry.pose);
  entry_.seen.reset();
  const PoseWithCovariance first = LocateFirst(Seen(kLast * kStep), T_odom_now);
  EXPECT_EQ(first.pose, by_odometry.pose);
  EXPECT_EQ(first.covariance, by_odometry.covariance);
}

}  // namespace
}  // namespace enfilade::slam
