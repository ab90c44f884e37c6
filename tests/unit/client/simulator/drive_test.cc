#include "client/simulator/drive.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/pose_matchers.h"
#include "tests/support/status_matchers.h"

namespace enfilade::simulator {
namespace {

using enfilade::testing::HasStatus;
using enfilade::testing::PoseNear;
using ::testing::HasSubstr;

template <typename T>
std::vector<T> AllOf(const Drive& drive) {
  std::vector<T> result;
  for (const auto& entry : drive.entries) {
    if (const T* payload = std::get_if<T>(&entry.payload)) result.push_back(*payload);
  }
  return result;
}

DriveOptions Noiseless() {
  DriveOptions options;
  options.laps = 1;
  options.range_sigma = options.dropout = options.wheel_sigma = options.slip = 0.0;
  return options;
}

TEST(SimulateDrive, SameOptionsSameDrive) {
  DriveOptions options;
  options.laps = 1;
  ASSERT_OK_AND_ASSIGN(const Drive first, SimulateDrive(EnfiladePlan(), options));
  ASSERT_OK_AND_ASSIGN(const Drive again, SimulateDrive(EnfiladePlan(), options));
  options.seed = 2;
  ASSERT_OK_AND_ASSIGN(const Drive other, SimulateDrive(EnfiladePlan(), options));
  EXPECT_EQ(AllOf<Odometry>(first), AllOf<Odometry>(again));
  EXPECT_NE(AllOf<Odometry>(first), AllOf<Odometry>(other));
  EXPECT_EQ(first.truth.size(), other.truth.size()) << "noise must not change the way";
}

TEST(SimulateDrive, RecordsAreValidAndInTheOrderOfTime) {
  ASSERT_OK_AND_ASSIGN(const Drive drive, SimulateDrive(EnfiladePlan(), {}));
  TimeNs last = 0;
  std::int64_t sequence = 0;
  for (const auto& entry : drive.entries) {
    const Record record{++sequence, entry.payload};
    ASSERT_OK(Validate(record));
    ASSERT_GE(TimeOf(record), last);
    last = TimeOf(record);
  }
  const auto scans = AllOf<LaserScan>(drive);
  ASSERT_EQ(scans.size(), drive.truth.size());
  EXPECT_EQ(scans.back().time, drive.truth.back().time);
  EXPECT_NEAR(static_cast<double>(AllOf<Odometry>(drive).size()) / static_cast<double>(scans.size()), 4.0, 0.1);
}

TEST(SimulateDrive, TheSecondLapSeesTheSamePlaces) {
  DriveOptions options = Noiseless();
  options.laps = 2;
  ASSERT_OK_AND_ASSIGN(const Drive drive, SimulateDrive(EnfiladePlan(), options));
  const TruePose& half_way = drive.truth[drive.truth.size() / 2];
  EXPECT_LT((half_way.T_plan_robot.translation() - drive.truth.back().T_plan_robot.translation()).norm(), 1.0);
}

TEST(SimulateDrive, WithoutNoiseOdometryIsTheTruth) {
  ASSERT_OK_AND_ASSIGN(const Drive drive, SimulateDrive(EnfiladePlan(), Noiseless()));
  const Pose2 T_plan_start = drive.truth.front().T_plan_robot;
  std::size_t checked = 0;
  for (const Odometry& odometry : AllOf<Odometry>(drive)) {
    if (checked == drive.truth.size() || odometry.time != drive.truth[checked].time) continue;
    ASSERT_THAT(T_plan_start * odometry.T_odom_robot, PoseNear(drive.truth[checked].T_plan_robot, 1e-9, 1e-9));
    ++checked;
  }
  EXPECT_EQ(checked, drive.truth.size());
}

TEST(SimulateDrive, WithNoiseOdometryDrifts) {
  ASSERT_OK_AND_ASSIGN(const Drive drive, SimulateDrive(EnfiladePlan(), {}));
  const Pose2 by_wheels = drive.truth.front().T_plan_robot * AllOf<Odometry>(drive).back().T_odom_robot;
  const double error = Between(by_wheels, drive.truth.back().T_plan_robot).translation().norm();
  EXPECT_GT(error, 0.3);
  EXPECT_LT(error, 20.0);
}

// Within a millimetre: a ray may end in the very corner of a wall and leave it again.
bool IsAtWall(const Eigen::Vector2d& point) {
  for (const double dx : {-0.001, 0.001}) {
    for (const double dy : {-0.001, 0.001}) {
      if (EnfiladePlan().IsWallAt(point + Eigen::Vector2d(dx, dy))) return true;
    }
  }
  return false;
}

TEST(SimulateDrive, HitsLieOnWalls) {
  ASSERT_OK_AND_ASSIGN(const Drive drive, SimulateDrive(EnfiladePlan(), Noiseless()));
  const auto scans = AllOf<LaserScan>(drive);
  for (std::size_t i = 0; i < scans.size(); i += 50) {
    const Pose2& T_plan_robot = drive.truth[i].T_plan_robot;
    const Eigen::Vector2d laser = (T_plan_robot * scans[i].T_robot_laser).translation();
    for (const Eigen::Vector2d& p_robot : HitPoints(scans[i], 12.0)) {
      const Eigen::Vector2d hit = T_plan_robot * p_robot;
      const Eigen::Vector2d on = (hit - laser).normalized();
      ASSERT_TRUE(IsAtWall(hit));
      ASSERT_FALSE(EnfiladePlan().IsWallAt(hit - 0.001 * on));
    }
  }
}

TEST(SimulateDrive, RefusesBadOptionsAndRoutes) {
  DriveOptions options;
  options.laps = 0;
  EXPECT_THAT(SimulateDrive(EnfiladePlan(), options),
              HasStatus(absl::StatusCode::kInvalidArgument, HasSubstr("laps is 0")));
  options = {};
  options.speed = NAN;
  EXPECT_THAT(SimulateDrive(EnfiladePlan(), options),
              HasStatus(absl::StatusCode::kInvalidArgument, HasSubstr("speed")));
  ASSERT_OK_AND_ASSIGN(const FloorPlan walled, FloorPlan::Parse("#######\n#a # b#\n#######", 1.0));
  EXPECT_THAT(SimulateDrive(walled, {}), HasStatus(absl::StatusCode::kFailedPrecondition, HasSubstr("into a wall")));
}

}  // namespace
}  // namespace enfilade::simulator
