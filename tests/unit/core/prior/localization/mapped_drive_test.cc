// SPDX-License-Identifier: Apache-2.0
// What comes before and after a robot is located in a plan: its scans, and where its plan is placed.
#include "core/prior/localization/mapped_drive.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

#include "core/prior/localization/drive_scans.h"
#include "core/prior/localization/mode_in_map.h"
#include "tests/support/plans/drawn_building.h"
#include "tests/unit/core/slam/synthetic_drive.h"

namespace enfilade::prior {
namespace {

using Eigen::Vector2d;
using ::testing::HasSubstr;

std::vector<sensor::PairedScan> ScansOf(const std::vector<Pose2>& truth) {
  std::vector<testing::Wall> walls;
  const PlanGraph plan = DrawnBuilding();
  for (const PlanWall& wall : plan.walls) {
    const Vector2d from = plan.corners[static_cast<std::size_t>(wall.from)].point;
    const Vector2d to = plan.corners[static_cast<std::size_t>(wall.to)].point;
    walls.push_back({0.05 * Vector2d(from.x(), -from.y()), 0.05 * Vector2d(to.x(), -to.y())});
  }
  return testing::Record(walls, truth, {.field_of_view = 2 * M_PI, .range_max = 10.0}, {}, 3);
}

const KeepGoing kOn = [] { return absl::OkStatus(); };

TEST(MapScansTest, GivesKeyframesWithTheirScansAndTheLastPose) {
  const std::vector<Pose2> truth = testing::Drive({{2.5, -5}, {2.5, -11.25}, {8.35, -11.25}}, 0.1);
  const auto mapped = MapScans(ScansOf(truth), slam::SlamOptions(), kOn);
  ASSERT_TRUE(mapped.ok()) << mapped.status();
  ASSERT_GT(mapped->drive.looks.size(), 10U);
  EXPECT_LT(mapped->drive.looks.size(), truth.size());
  EXPECT_EQ(mapped->drive.times.size(), mapped->drive.looks.size());
  EXPECT_FALSE(mapped->drive.submaps.empty());
  const Pose2 last = truth.front() * mapped->T_map_robot;
  EXPECT_LT((last.translation() - truth.back().translation()).norm(), 0.1) << "the last scan, keyframe or not";
  EXPECT_GT(mapped->drive.looks.front().look.hits.size(), 100U);
}

TEST(MapScansTest, EndsWhenNobodyWaits) {
  int asked = 0;
  const auto mapped = MapScans(ScansOf(testing::Drive({{2.5, -5}, {2.5, -9}}, 0.1)), slam::SlamOptions(),
                               [&] { return ++asked < 5 ? absl::OkStatus() : absl::DeadlineExceededError("late"); });
  EXPECT_EQ(mapped.status().code(), absl::StatusCode::kDeadlineExceeded);
  EXPECT_EQ(asked, 5);
}

TEST(CheckDriveScansTest, NamesTheScanThatIsWrong) {
  const std::vector<sensor::PairedScan> good = ScansOf(testing::Drive({{2.5, -5}, {2.5, -9}}, 0.5));
  const auto message = [](const std::vector<sensor::PairedScan>& scans, const DriveScanRules& rules = {}) {
    const absl::Status status = CheckDriveScans(scans, rules);
    EXPECT_EQ(status.code(), status.ok() ? absl::StatusCode::kOk : absl::StatusCode::kInvalidArgument);
    return std::string(status.message());
  };
  EXPECT_EQ(message(good), "");
  EXPECT_EQ(message(good, {.least_distance = 3.9}), "");
  EXPECT_THAT(message(good, {.least_distance = 5}), HasSubstr("drove 4.0 m"));
  EXPECT_THAT(message({}), HasSubstr("no scans"));
  auto bad = good;
  bad[2].T_odom_robot.reset();
  EXPECT_THAT(message(bad), HasSubstr("scans[2] has no odometry"));
  bad = good;
  bad[2].T_odom_robot->x = std::nan("");
  EXPECT_THAT(message(bad), HasSubstr("scans[2]: the odometry"));
  bad = good;
  bad[2].scan.ranges.clear();
  EXPECT_THAT(message(bad), HasSubstr("scans[2]: "));
  bad = good;
  std::swap(bad[2], bad[3]);
  EXPECT_THAT(message(bad), HasSubstr("scans[3] was taken 0.500 s before scans[2]"));
  bad = good;
  bad[2].T_odom_robot->x += 4;
  EXPECT_THAT(message(bad), HasSubstr("scans[2] is "));
  bad = good;
  bad[2].scan.time = bad[1].scan.time + kNsPerSecond / 100;
  EXPECT_THAT(message(bad), HasSubstr("from scans[1] to scans[2]"));
  bad = good;
  for (sensor::PairedScan& scan : bad) scan.scan.ranges.assign(scan.scan.ranges.size(), std::nanf(""));
  EXPECT_THAT(message(bad), HasSubstr("no scan has 30 hits"));
}

// A plan whose unit is 0.05 m along x and 0.04 m along y, placed in a map, and a robot in it.
class InMapTest : public ::testing::TestWithParam<bool> {
 protected:
  InMapTest() {
    const Eigen::Matrix2d turn = Eigen::Rotation2Dd(0.7).toRotationMatrix();
    const Eigen::Matrix2d units = Vector2d(0.05, GetParam() ? 0.04 : -0.04).asDiagonal();
    T_map_sheet_ = {turn * units, {3, -2}};
    mode_.mean.mirrored = GetParam();
    mode_.mean.log_scale = 0.5 * std::log(0.05 / 0.04);
    const bool is_along_x = std::abs(std::cos(field_.axis())) > 0.5;
    mode_.mean.log_stretch = (is_along_x ? 0.5 : -0.5) * std::log(0.05 / 0.04);
    mode_.covariance.diagonal() << 0.04, 0.01, 0.0025, 1;
  }
  PlanField field_{DrawnBuilding(), 0.04};
  PlanTransform T_map_sheet_;
  PlanMode mode_;
};
INSTANTIATE_TEST_SUITE_P(Sides, InMapTest, ::testing::Bool());

TEST_P(InMapTest, IsWhereTheRobotsOwnPointsLie) {
  EXPECT_EQ(T_map_sheet_.mirrored(), GetParam());
  const Pose2 truth{8.0, 1.5, -2.2};
  const Vector2d plan = field_.ToPlan(ToSheet(T_map_sheet_, truth.translation()));
  mode_.mean.x = plan.x();
  mode_.mean.y = plan.y();
  // In the plan's metres the map is turned by 0.7 against it, one way or the other.
  mode_.mean.yaw = WrapAngle(GetParam() ? -(truth.yaw - 0.7) : truth.yaw - 0.7);
  const auto pose = InMap(field_, mode_, T_map_sheet_);
  ASSERT_TRUE(pose);
  EXPECT_LT((pose->pose.translation() - truth.translation()).norm(), 1e-9);
  EXPECT_NEAR(WrapAngle(pose->pose.yaw - truth.yaw), 0, 1e-6);
  const Eigen::Matrix2d place = pose->covariance.topLeftCorner<2, 2>();
  EXPECT_NEAR(place.trace(), 0.05, 1e-6);
  EXPECT_NEAR(place.determinant(), 0.0004, 1e-6);
  EXPECT_NEAR(pose->covariance(2, 2), 0.0025, 1e-9);
  mode_.mean.mirrored = !mode_.mean.mirrored;
  EXPECT_FALSE(InMap(field_, mode_, T_map_sheet_)) << "one of them is wrong";
}

}  // namespace
}  // namespace enfilade::prior
