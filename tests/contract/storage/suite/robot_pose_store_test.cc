// SPDX-License-Identifier: Apache-2.0
#include "storage/graph/robot_pose_store.h"

#include <chrono>
#include <cmath>

#include "tests/contract/storage/suite/contract_test.h"

namespace enfilade::testing {
namespace {

using ::testing::SizeIs;

class RobotPoseStoreTest : public StoreContractTest {
 protected:
  storage::RobotPose At(double x, TimeNs time) {
    storage::RobotPose pose{site_, robot_, map_, std::nullopt, {}, time, 0};
    pose.T_map_robot = {{x, 2.0, 0.5}, Eigen::Vector3d(0.1, 0.2, 0.3).asDiagonal()};
    return pose;
  }
};

TEST_F(RobotPoseStoreTest, TheNewestByItsTimeWins) {
  EXPECT_CODE(robot_poses_.Get(Soon(), site_, robot_), absl::StatusCode::kNotFound);
  const SessionId session = NewSession("s");
  storage::RobotPose pose = At(1.0, 1'000'000'001);
  pose.session = session;
  ASSERT_OK(robot_poses_.Report(Soon(), pose));
  ASSERT_OK(robot_poses_.Report(Soon(), At(9.0, 999)));
  ASSERT_OK_AND_ASSIGN(const storage::RobotPose first, robot_poses_.Get(Soon(), site_, robot_));
  EXPECT_EQ(first.T_map_robot.pose, pose.T_map_robot.pose);
  EXPECT_EQ(first.T_map_robot.covariance, pose.T_map_robot.covariance);
  EXPECT_EQ(first.time, 1'000'000'001);
  EXPECT_EQ(first.session, session);
  ASSERT_OK(robot_poses_.Report(Soon(), At(2.0, 1'000'000'002)));
  ASSERT_OK_AND_ASSIGN(const auto listed, robot_poses_.List(Soon(), site_));
  ASSERT_THAT(listed, SizeIs(1));
  EXPECT_EQ(listed[0].T_map_robot.pose.x, 2.0);
  EXPECT_GT(listed[0].version, first.version);
  EXPECT_FALSE(listed[0].session);
}

TEST_F(RobotPoseStoreTest, AMomentsPoseIsReplacedOnlyByItsOwnSession) {
  const SessionId session = NewSession("s");
  const auto of_session = [&](double x) {
    storage::RobotPose pose = At(x, 1'000'000'001);
    pose.session = session;
    return pose;
  };
  ASSERT_OK(robot_poses_.Report(Soon(), of_session(1.0)));
  ASSERT_OK(robot_poses_.Report(Soon(), of_session(1.004)));  // the same scan, after another solve
  ASSERT_OK(robot_poses_.Report(Soon(), At(9.0, 1'000'000'001)));
  ASSERT_OK_AND_ASSIGN(const storage::RobotPose stored, robot_poses_.Get(Soon(), site_, robot_));
  EXPECT_EQ(stored.T_map_robot.pose.x, 1.004);
  EXPECT_EQ(stored.session, session);
}

TEST_F(RobotPoseStoreTest, ATimeAheadOfTheServersClockSilencesNoRobot) {
  const auto now = [] { return std::chrono::nanoseconds(std::chrono::system_clock::now().time_since_epoch()).count(); };
  EXPECT_STATUS(robot_poses_.Report(Soon(), At(9.0, 7'226'582'400 * kNsPerSecond)), absl::StatusCode::kInvalidArgument,
                ::testing::HasSubstr("ahead of the server's clock"));
  const TimeNs begin = now();
  ASSERT_OK(robot_poses_.Report(Soon(), At(1.0, begin + storage::kMaxPoseLead / 2)));
  ASSERT_OK_AND_ASSIGN(const storage::RobotPose ahead, robot_poses_.Get(Soon(), site_, robot_));
  EXPECT_EQ(ahead.time, begin + storage::kMaxPoseLead / 2);
  EXPECT_GE(ahead.received, begin);
  EXPECT_LE(ahead.received, now());
  // The robot's clock is set right: what it reports now is later.
  ASSERT_OK(robot_poses_.Report(Soon(), At(2.0, now())));
  ASSERT_OK_AND_ASSIGN(const storage::RobotPose stored, robot_poses_.Get(Soon(), site_, robot_));
  EXPECT_EQ(stored.T_map_robot.pose.x, 2.0);
}

TEST_F(RobotPoseStoreTest, SaysWhatIsMissingOrWrong) {
  storage::RobotPose pose = At(1.0, 1);
  pose.map = MapId("cellar");
  EXPECT_STATUS(robot_poses_.Report(Soon(), pose), absl::StatusCode::kNotFound, ::testing::HasSubstr("cellar"));
  pose = At(1.0, 1);
  pose.robot = RobotId("r9");
  EXPECT_STATUS(robot_poses_.Report(Soon(), pose), absl::StatusCode::kNotFound, ::testing::HasSubstr("r9"));
  EXPECT_CODE(robot_poses_.Report(Soon(), At(std::nan(""), 1)), absl::StatusCode::kInvalidArgument);
  pose = At(1.0, 1);
  pose.T_map_robot.covariance(0, 0) = -1.0;
  EXPECT_CODE(robot_poses_.Report(Soon(), pose), absl::StatusCode::kInvalidArgument);
}

TEST_F(RobotPoseStoreTest, AnswersEachOfManyReports) {
  const RobotId second("r2"), third("r3");
  for (const RobotId& robot : {second, third}) backend_->AddRobot(site_, robot);
  std::vector<storage::RobotPose> reports(7, At(1.0, 1'000'000'001));
  reports[1].robot = second;
  reports[1].map = MapId("cellar");
  reports[2].robot = RobotId("r9");
  reports[3].robot = second;
  reports[3].T_map_robot.pose.x = 3.0;
  reports[4] = At(4.0, 1'000'000'002);  // the first robot once more, and then an older pose
  reports[5] = At(5.0, 1'000'000'000);
  reports[6].robot = third;
  reports[6].T_map_robot.pose.x = std::nan("");
  const std::vector<absl::Status> answers = robot_poses_.ReportAll(Soon(), reports);
  ASSERT_THAT(answers, SizeIs(7));
  for (const std::size_t i : {0U, 3U, 4U, 5U}) EXPECT_OK(answers[i]) << i;
  EXPECT_STATUS(answers[1], absl::StatusCode::kNotFound, ::testing::HasSubstr("cellar"));
  EXPECT_STATUS(answers[2], absl::StatusCode::kNotFound, ::testing::HasSubstr("r9"));
  EXPECT_CODE(answers[6], absl::StatusCode::kInvalidArgument);
  ASSERT_OK_AND_ASSIGN(const auto stored, robot_poses_.List(Soon(), site_));
  ASSERT_THAT(stored, SizeIs(2));
  EXPECT_EQ(stored[0].T_map_robot.pose.x, 4.0);
  EXPECT_EQ(stored[0].T_map_robot.covariance, reports[4].T_map_robot.covariance);
  EXPECT_EQ(stored[1].robot, second);
  EXPECT_EQ(stored[1].T_map_robot.pose.x, 3.0);
  EXPECT_EQ(stored[1].T_map_robot.covariance, reports[3].T_map_robot.covariance);
  EXPECT_THAT(robot_poses_.ReportAll(Soon(), {}), SizeIs(0));
}

}  // namespace
}  // namespace enfilade::testing
