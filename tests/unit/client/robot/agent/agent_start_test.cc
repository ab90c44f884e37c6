// SPDX-License-Identifier: Apache-2.0
// A robot that does not know where it starts.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "client/robot/agent/agent.h"
#include "tests/support/eventually.h"
#include "tests/support/fake_server/fake_server.h"
#include "tests/support/status_assertions.h"
#include "tests/support/test_data.h"

namespace enfilade::robot {
namespace {

using testing::Eventually;
using testing::FakeServer;

class AgentStartTest : public ::testing::Test {
 protected:
  AgentStartTest() {
    spool_ = *client::Spool::Open((directory_.path() / "robot.spool").string());
    UploaderOptions options;
    options.uplink.min_backoff_s = 0.001;
    options.uplink.max_backoff_s = 0.02;
    options.follow_s = 0.02;
    uploader_ = std::make_unique<Uploader>(
        connection_, *spool_, convert::RobotName{SiteId("s"), RobotId("r1")}, [](const Notification&) {}, options);
    uploader_->Start();
  }
  ~AgentStartTest() override { uploader_->Stop(); }

  void Start(bool automatic = true) {
    AgentSetup setup;
    setup.site = SiteId("s");
    setup.robot = RobotId("r1");
    setup.options.automatic = automatic;
    setup.options.spool.wait_when_full = wait_when_full_;
    setup.start = LocateRobot{};
    auto agent = Agent::Make(std::move(setup),
                             {connection_, *spool_, *uploader_, [](const Notification&) {}, [] { return false; },
                              [this](const std::vector<sensor::PairedScan>& scans) {
                                ++asked_;
                                last_asked_ = scans.back();
                                return answer_;
                              }});
    ASSERT_OK(agent.status());
    agent_ = *std::move(agent);
    ASSERT_OK(agent_->Start());
  }
  // A session of an earlier run, which is not uploaded yet.
  void RecordEarlier() {
    client::SpoolSession earlier;
    earlier.site = SiteId("s");
    earlier.robot = RobotId("r1");
    earlier.id = SessionId("earlier");
    earlier.request_id = "request";
    earlier.map = "hall";
    ASSERT_OK(spool_->CreateSession(earlier));
    ASSERT_OK(spool_->MarkFinished(earlier.id));
  }
  // Along x in a round room, 0.1 m a step.
  void Drive(double metres) {
    for (const double end = x_ + metres; x_ < end; x_ += 0.1) {
      time_ += kNsPerSecond / 5;
      ASSERT_OK(agent_->Add({sensor::Odometry{time_, {x_, 0.0, 0.0}}, {}}));
      sensor::LaserScan scan;
      scan.time = time_;
      scan.angle_min = -M_PI;
      scan.angle_increment = 2.0 * M_PI / 90.0;
      scan.range_min = 0.1F;
      scan.range_max = 30.0F;
      scan.ranges.assign(90, 4.0F);
      ASSERT_OK(agent_->Add({scan, {}}));
    }
  }
  static StartAnswer Hypothesis() {
    StartAnswer answer;
    answer.map = "hall";
    answer.T_map_robot = {{3.0, 4.0, 1.5}, Eigen::Matrix3d::Identity() * 0.01};
    answer.hypotheses = 2;
    answer.maps_searched = 3;
    return answer;
  }
  client::SpoolSession Session() { return spool_->ListSessions().at(0); }

  testing::TemporaryDirectory directory_;
  const std::string address_ = "unix:" + (directory_.path() / "server").string();
  FakeServer server_{address_};
  client::Connection connection_{address_, std::chrono::seconds(5)};
  std::unique_ptr<client::Spool> spool_;
  std::unique_ptr<Uploader> uploader_;
  std::unique_ptr<Agent> agent_;
  absl::StatusOr<StartAnswer> answer_ = Hypothesis();
  bool wait_when_full_ = true;
  std::atomic<int> asked_ = 0;
  sensor::PairedScan last_asked_;
  double x_ = 0.0;
  TimeNs time_ = kNsPerSecond;
};

TEST_F(AgentStartTest, TheSessionWaitsInTheSpoolAndThenGoesWhereTheRobotIsFound) {
  Start();
  Drive(3.0);
  EXPECT_GE(asked_, 3);
  const client::SpoolSession waiting = Session();
  EXPECT_FALSE(waiting.entry.T_map_robot);
  EXPECT_EQ(waiting.acknowledged_sequence, 0);
  answer_->confident = true;
  Drive(2.0);
  const client::SpoolSession found = Session();
  EXPECT_EQ(found.id, waiting.id);
  EXPECT_EQ(found.map, "hall");
  ASSERT_TRUE(found.entry.T_map_robot);
  EXPECT_EQ(found.entry.T_map_robot->pose, (Pose2{3.0, 4.0, 1.5}));
  EXPECT_EQ(found.entry.T_odom_robot, last_asked_.T_odom_robot) << "of the scan that was asked about";
  const int asked = asked_;
  Drive(5.0);
  EXPECT_EQ(asked_, asked) << "it knows where it is";
}

TEST_F(AgentStartTest, NothingIsUploadedBeforeItIsDecidedAndAllOfItAfterwards) {
  Start();
  Drive(9.0);
  EXPECT_EQ(uploader_->progress().session, "");
  Drive(2.0);
  EXPECT_TRUE(Eventually([&] { return uploader_->progress().session == Session().id.value(); }))
      << "after 10 m a new map begins";
  EXPECT_FALSE(Session().entry.T_map_robot);
}

TEST_F(AgentStartTest, ARobotDoesNotAskBeforeItsEarlierSessionsAreMapped) {
  RecordEarlier();
  answer_->confident = true;
  wait_when_full_ = false;  // a live robot
  Start();
  Drive(3.0);
  EXPECT_EQ(asked_, 0);
  ASSERT_TRUE(Eventually([&] { return uploader_->progress().unmapped == 1; })) << "received";
  Drive(2.0);
  EXPECT_EQ(asked_, 0);
  server_.Edit("sites/s/sessions/earlier",
               [](FakeServer::Session& session) { session.session.set_state(v1::Session::STATE_MAPPED); });
  ASSERT_TRUE(Eventually([&] { return uploader_->EarlierMapped(); }));
  Drive(2.0);
  // A live robot does not wait for the thread that asks.
  EXPECT_TRUE(Eventually([&] { return asked_ == 1; }));
}

TEST_F(AgentStartTest, ALogDoesNotWaitForAServerThatIsAway) {
  server_.Stop();
  RecordEarlier();
  Start();
  Drive(11.0);
  EXPECT_EQ(asked_, 0);
  EXPECT_EQ(spool_->ListSessions().size(), 2U);
}

TEST_F(AgentStartTest, AtTheEndOfTheDriveTheMapIsANewOne) {
  Start();
  Drive(1.0);
  ASSERT_OK(agent_->Finish());
  EXPECT_TRUE(Eventually([&] { return uploader_->Done(false); }));
}

TEST_F(AgentStartTest, ALiveRobotDoesNotWaitForTheAnswer) {
  AgentSetup setup;
  setup.site = SiteId("s");
  setup.robot = RobotId("r1");
  setup.options.spool.wait_when_full = false;
  setup.start = LocateRobot{};
  std::promise<void> may_answer;
  std::shared_future<void> allowed = may_answer.get_future().share();
  StartAnswer answer = Hypothesis();
  answer.confident = true;
  auto agent =
      Agent::Make(std::move(setup), {connection_, *spool_, *uploader_, [](const Notification&) {}, [] { return false; },
                                     [=](const std::vector<sensor::PairedScan>&) {
                                       allowed.wait();
                                       return absl::StatusOr<StartAnswer>(answer);
                                     }});
  ASSERT_OK(agent.status());
  agent_ = *std::move(agent);
  ASSERT_OK(agent_->Start());
  Drive(2.0);
  EXPECT_FALSE(Session().entry.T_map_robot);
  may_answer.set_value();
  EXPECT_TRUE(Eventually([&] {
    Drive(0.1);
    return Session().entry.T_map_robot.has_value();
  }));
  EXPECT_NEAR(Session().entry.T_odom_robot->x, 0.0, 0.2) << "where the first scan was taken";
}

TEST_F(AgentStartTest, ARobotThatGoesThroughADoorUnlocatedBeginsANewMap) {
  Start();
  Drive(1.0);
  ASSERT_OK(agent_->Do(SetLinkPoint{}));
  EXPECT_EQ(spool_->ListSessions().size(), 2U);
  EXPECT_FALSE(Session().entry.T_map_robot);
  EXPECT_TRUE(Eventually([&] { return Session().closed || spool_->ListSessions().size() == 1; })) << "uploaded";
  const int asked = asked_;
  Drive(3.0);
  EXPECT_EQ(asked_, asked) << "the verdict on the passage says where it is";
}

TEST_F(AgentStartTest, ARobotThatIsToldItsMapDoesNotAsk) {
  Start(false);
  ASSERT_OK(agent_->Do(RecordNewMap{"Hall"}));
  Drive(1.0);
  EXPECT_EQ(asked_, 0) << "a person has said where it is";
}

}  // namespace
}  // namespace enfilade::robot
