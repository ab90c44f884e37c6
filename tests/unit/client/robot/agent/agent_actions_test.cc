// SPDX-License-Identifier: Apache-2.0
// What the agent records and reports for the state machine's actions.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "client/robot/agent/agent.h"
#include "client/sources/content.h"
#include "tests/support/status_assertions.h"
#include "tests/support/test_data.h"

namespace enfilade::robot {
namespace {

using client::SpoolItem;
using client::SpoolSession;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// No server: nothing that these actions do needs one.
class AgentActionsTest : public ::testing::Test {
 protected:
  AgentActionsTest() {
    spool_ = *client::Spool::Open((directory_.path() / "robot.spool").string());
    uploader_ = std::make_unique<Uploader>(connection_, *spool_, convert::RobotName{SiteId("s"), RobotId("r1")},
                                           listener_, UploaderOptions{});
    options_.automatic = false;
  }

  void Start() {
    AgentSetup setup;
    setup.site = SiteId("s");
    setup.robot = RobotId("r1");
    setup.source = "a test";
    setup.options = options_;
    absl::StatusOr<std::unique_ptr<Agent>> agent =
        Agent::Make(std::move(setup), {connection_, *spool_, *uploader_, listener_, [] { return false; }});
    ASSERT_OK(agent.status());
    agent_ = *std::move(agent);
    ASSERT_OK(agent_->Start());
  }
  void StartMapping(const Command& command = RecordNewMap{"Hall"}) {
    Start();
    ASSERT_OK(agent_->Do(command));
    Step(0.0);
  }
  // One step of the drive along x: odometry, a scan of a room of 8 m (or of open ground) and odometry again.
  void Step(double x, bool outdoors = false) {
    time_ += kNsPerSecond / 5;
    ASSERT_OK(agent_->Add({sensor::Odometry{time_ - 1, {x, 0.0, 0.0}}, {}}));
    sensor::LaserScan scan;
    scan.time = time_;
    scan.angle_min = -M_PI;
    scan.angle_increment = 2.0 * M_PI / 90.0;
    scan.range_min = 0.1F;
    scan.range_max = 100.0F;
    scan.ranges.assign(90, outdoors ? 40.0F : 4.0F);
    ASSERT_OK(agent_->Add({scan, {}}));
    ASSERT_OK(agent_->Add({sensor::Odometry{time_ + 1, {x, 0.0, 0.0}}, {}}));
  }
  void Image(sensor::Camera camera = sensor::Camera::kFront) {
    const std::string content = "image " + std::to_string(++images_);
    ASSERT_OK(
        agent_->Add({sensor::Image{time_, camera, sensor::ImageEncoding::kPng, sources::RefOf(content)}, content}));
  }
  void Cloud() {
    const std::string content = "cloud " + std::to_string(++images_);
    ASSERT_OK(
        agent_->Add({sensor::PointCloud{time_, sensor::CloudEncoding::kXyz32, sources::RefOf(content)}, content}));
  }

  std::vector<Notification> Of(const std::string& event) {
    MutexLock lock(mutex_);
    std::vector<Notification> found;
    for (const Notification& one : notifications_) {
      if (one.event == event) found.push_back(one);
    }
    return found;
  }
  std::vector<sensor::Record> RecordsOf(std::size_t session) {
    return *spool_->ReadBatch(spool_->ListSessions().at(session).id, 0, 10'000, 64LL << 20);
  }
  // The kinds of the last `count` records, without scans and odometry.
  std::vector<std::string> EvidenceOf(std::size_t session) {
    std::vector<std::string> kinds;
    for (const sensor::Record& record : RecordsOf(session)) {
      if (const auto* image = std::get_if<sensor::Image>(&record.payload)) {
        kinds.emplace_back(image->camera == sensor::Camera::kRear ? "rear" : "front");
      }
      if (std::holds_alternative<sensor::PointCloud>(record.payload)) kinds.emplace_back("cloud");
      if (const auto* report = std::get_if<sensor::DoorReport>(&record.payload)) {
        kinds.emplace_back(report->kind == sensor::DoorReport::Kind::kPassage ? "passage" : "candidate");
      }
    }
    return kinds;
  }

  testing::TemporaryDirectory directory_;
  Mutex mutex_;
  std::vector<Notification> notifications_;
  const NotificationListener listener_ = [this](const Notification& notification) {
    MutexLock lock(mutex_);
    notifications_.push_back(notification);
  };
  client::Connection connection_{"unix:" + (directory_.path() / "no-server").string(), std::chrono::seconds(1)};
  RobotOptions options_;
  std::unique_ptr<client::Spool> spool_;
  std::unique_ptr<Uploader> uploader_;
  std::unique_ptr<Agent> agent_;
  TimeNs time_ = 100 * kNsPerSecond;
  int images_ = 0;
};

TEST_F(AgentActionsTest, ACandidateComesWithWhatIsSeenThere) {
  StartMapping();
  Image();
  Image(sensor::Camera::kRear);
  Cloud();
  ASSERT_OK(agent_->Do(SetCandidate{graph::LinkPointKind::kStairs}));
  EXPECT_THAT(EvidenceOf(0), ElementsAre("front", "rear", "cloud", "candidate"));
  const auto report = std::get<sensor::DoorReport>(RecordsOf(0).back().payload);
  EXPECT_EQ(report.place, graph::LinkPointKind::kStairs);
  EXPECT_TRUE(report.by_hand);
  EXPECT_FALSE(report.entered_environment) << "only a passage enters anything";
  const Notification told = Of("report").at(0);
  EXPECT_EQ(told.text, "candidate reported with 3 images and clouds");
  EXPECT_EQ(told.fields.at("evidence"), 3);
  EXPECT_EQ(told.fields.at("kind"), "candidate");
  EXPECT_TRUE(told.fields.at("surroundings").is_null());
}

TEST_F(AgentActionsTest, APassageReportsTheEnvironmentEntered) {
  StartMapping();
  for (int i = 1; i < 6; ++i) Step(0.5 * i, true);
  ASSERT_OK(agent_->Do(SetLinkPoint{graph::LinkPointKind::kLift, 2}));
  const auto report = std::get<sensor::DoorReport>(RecordsOf(0).back().payload);
  EXPECT_EQ(report.kind, sensor::DoorReport::Kind::kPassage);
  EXPECT_EQ(report.entered_environment, Environment::kOutdoor);
  EXPECT_EQ(report.entered_level, 2);
  EXPECT_EQ(Of("report").at(0).fields.at("surroundings"), ToString(Environment::kOutdoor));
  const std::vector<SpoolSession> sessions = spool_->ListSessions();
  ASSERT_EQ(sessions.size(), 2U);
  EXPECT_TRUE(sessions[0].finished);
  EXPECT_EQ(sessions[1].entry.previous, sessions[0].id);
  EXPECT_EQ(sessions[1].map, "");
  EXPECT_EQ(agent_->counts().passages, 1);
  EXPECT_EQ(agent_->counts().sessions, 2);
}

TEST_F(AgentActionsTest, WhatIsSavedBeforeADoorBelongsToIt) {
  StartMapping();
  Image();
  ASSERT_OK(agent_->Do(SaveRearImage{}));
  for (int i = 1; i < 40; ++i) Step(0.2 * i);  // the saved view is too old by now
  ASSERT_OK(agent_->Do(SetCandidate{}));
  EXPECT_THAT(EvidenceOf(0), ElementsAre("front", "candidate"));
  ASSERT_OK(agent_->Do(SetCandidate{}));
  EXPECT_THAT(EvidenceOf(0), ElementsAre("front", "candidate", "candidate")) << "it is used once";
}

TEST_F(AgentActionsTest, NoImageIsRecordedTwice) {
  StartMapping();
  Image();
  Cloud();
  ASSERT_OK(agent_->Do(SetCandidate{}));
  ASSERT_OK(agent_->Do(SetCandidate{}));
  EXPECT_THAT(EvidenceOf(0), ElementsAre("front", "cloud", "candidate", "candidate"));
  EXPECT_EQ(Of("report").at(1).fields.at("evidence"), 0);
}

TEST_F(AgentActionsTest, EvidenceCanBeSwitchedOff) {
  options_.record_imgs_and_pc = false;
  StartMapping();
  Image();
  ASSERT_OK(agent_->Do(SaveRearImage{}));
  ASSERT_OK(agent_->Do(SetCandidate{}));
  EXPECT_THAT(EvidenceOf(0), ElementsAre("candidate"));
}

TEST_F(AgentActionsTest, ANewMapKnowsItsEnvironmentAndAnExistingOneItsPose) {
  StartMapping();
  EXPECT_EQ(spool_->ListSessions().at(0).environment, Environment::kIndoor);
  EXPECT_FALSE(spool_->ListSessions().at(0).entry.T_map_robot);
  ASSERT_OK(agent_->Do(StopMapping{}));
  ASSERT_OK(agent_->Do(MapOnExistingMap{"Yard", {{1.0, 2.0, 0.5}, Eigen::Matrix3d::Identity()}}));
  Step(0.0, true);
  const SpoolSession existing = spool_->ListSessions().at(1);
  EXPECT_EQ(existing.map, "Yard");
  ASSERT_TRUE(existing.entry.T_map_robot);
  EXPECT_EQ(existing.entry.T_map_robot->pose, (Pose2{1.0, 2.0, 0.5}));
  EXPECT_FALSE(existing.environment) << "the map has one";
  EXPECT_EQ(existing.entry.previous, std::nullopt);
}

TEST_F(AgentActionsTest, AMapWithoutANameIsNamedAfterTheRobot) {
  StartMapping(RecordNewMap{""});
  EXPECT_THAT(spool_->ListSessions().at(0).map, ::testing::MatchesRegex("r1 [0-9-]+ [0-9:]+"));
  EXPECT_EQ(spool_->ListSessions().at(0).source, "a test");
}

TEST_F(AgentActionsTest, ASessionBeginsWithOdometryOnBothSidesOfItsFirstScan) {
  StartMapping();
  Step(0.1);
  ASSERT_OK(agent_->Do(StopMapping{}));
  const std::vector<sensor::Record> records = RecordsOf(0);
  ASSERT_GE(records.size(), 3U);
  EXPECT_TRUE(std::holds_alternative<sensor::Odometry>(records[0].payload));
  EXPECT_TRUE(std::holds_alternative<sensor::LaserScan>(records[1].payload));
  EXPECT_TRUE(std::holds_alternative<sensor::Odometry>(records[2].payload));
  EXPECT_LT(sensor::TimeOf(records[0]), sensor::TimeOf(records[1]));
}

TEST_F(AgentActionsTest, TheStatusCountsEverything) {
  StartMapping();
  Image();
  ASSERT_OK(agent_->Do(SetCandidate{}));
  ASSERT_OK(agent_->Do(AskStatus{}));
  const Notification status = Of("status").at(0);
  EXPECT_EQ(status.fields.at("state"), "Mapping");
  EXPECT_EQ(status.fields.at("candidates"), 1);
  EXPECT_EQ(status.fields.at("evidence"), 1);
  EXPECT_EQ(status.fields.at("records"), static_cast<std::int64_t>(RecordsOf(0).size()));
  EXPECT_EQ(status.fields.at("spool").at("records"), static_cast<std::int64_t>(RecordsOf(0).size()));
  EXPECT_EQ(status.fields.at("session"), spool_->ListSessions().at(0).id.value());
  EXPECT_THAT(status.text, HasSubstr("Mapping; map unknown; 1 sessions, 1 candidates, 0 passages"));
}

TEST_F(AgentActionsTest, DeletingReportsThatTheServerIsDown) {
  Start();
  ASSERT_OK(agent_->Do(DeleteMap{"m1"}));
  ASSERT_OK(agent_->Do(DeleteLinkPoint{"l1"}));
  const std::vector<Notification> deleted = Of("deleted");
  ASSERT_EQ(deleted.size(), 2U);
  EXPECT_FALSE(deleted[0].fields.at("ok"));
  EXPECT_EQ(deleted[0].fields.at("map"), "m1");
  EXPECT_EQ(deleted[1].fields.at("link_point"), "l1");
  EXPECT_EQ(Of("menu").size(), 3U) << "the menu is shown again after each";
  EXPECT_EQ(agent_->state(), State::kMainMenu);
}

TEST_F(AgentActionsTest, TheMenuNamesItsCommands) {
  Start();
  const std::string menu = Of("menu").at(0).text;
  for (const char* command : {"new ", "existing MAP X Y YAW", "delete-map", "delete-link-point", "abort"}) {
    EXPECT_THAT(menu, HasSubstr(command));
  }
}

}  // namespace
}  // namespace enfilade::robot
