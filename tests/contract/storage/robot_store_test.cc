// SPDX-License-Identifier: Apache-2.0
#include "storage/sites/robot_store.h"

#include "tests/contract/storage/store_test.h"

namespace enfilade::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::SizeIs;

class RobotStoreTest : public StoreTest {};

TEST_F(RobotStoreTest, CreatesReadsUpdatesAndDeletes) {
  ASSERT_OK_AND_ASSIGN(storage::Robot robot,
                       robots_.Create(Soon(), MakeRobot(site_, RobotId("r2"), "it's \"2\""), "request"));
  ASSERT_OK_AND_ASSIGN(const storage::Robot repeated,
                       robots_.Create(Soon(), MakeRobot(site_, RobotId("r3"), "it's \"2\""), "request"));
  EXPECT_EQ(repeated.id, robot.id);
  robot.display_name = "two";
  ASSERT_OK_AND_ASSIGN(const storage::Robot updated, robots_.Update(Soon(), robot));
  EXPECT_CODE(robots_.Update(Soon(), robot), absl::StatusCode::kAborted);
  ASSERT_OK_AND_ASSIGN(const storage::Robot stored, robots_.Get(Soon(), site_, robot.id));
  EXPECT_EQ(stored.display_name, "two");
  EXPECT_CODE(robots_.Delete(Soon(), site_, robot.id, robot.etag), absl::StatusCode::kAborted);
  EXPECT_OK(robots_.Delete(Soon(), site_, robot.id, updated.etag));
  EXPECT_CODE(robots_.Delete(Soon(), site_, robot.id, 0), absl::StatusCode::kNotFound);
}

TEST_F(RobotStoreTest, SaysWhetherTheSiteIsMissingOrTheRobotIsThere) {
  EXPECT_STATUS(robots_.Create(Soon(), MakeRobot(SiteId("nowhere"), robot_, "x"), ""), absl::StatusCode::kNotFound,
                HasSubstr("sites/nowhere does not exist"));
  EXPECT_STATUS(robots_.Create(Soon(), MakeRobot(site_, robot_, "x"), ""), absl::StatusCode::kAlreadyExists,
                HasSubstr("sites/campus/robots/r1"));
}

TEST_F(RobotStoreTest, IsKeptWhileItHasSessions) {
  const SessionId session = NewSession("s1");
  EXPECT_STATUS(robots_.Delete(Soon(), site_, robot_, 0), absl::StatusCode::kFailedPrecondition,
                HasSubstr("still has sessions"));
  ASSERT_OK(sessions_.Delete(Soon(), site_, session));
  EXPECT_OK(robots_.Delete(Soon(), site_, robot_, 0));
}

TEST_F(RobotStoreTest, TheSameIdInAnotherSiteIsAnotherRobot) {
  ASSERT_OK(sites_.Create(Soon(), MakeSite(SiteId("other"), "x"), ""));
  ASSERT_OK(robots_.Create(Soon(), MakeRobot(SiteId("other"), robot_, "Other"), ""));
  ASSERT_OK_AND_ASSIGN(const storage::Robot robot, robots_.Get(Soon(), site_, robot_));
  EXPECT_EQ(robot.display_name, "Robot 1");
}

}  // namespace
}  // namespace enfilade::testing
