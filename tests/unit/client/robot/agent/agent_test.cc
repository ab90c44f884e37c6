// SPDX-License-Identifier: Apache-2.0
#include "client/robot/agent/agent.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "client/robot/run.h"
#include "client/simulator/simulation_files.h"
#include "client/sources/content.h"
#include "core/base/environment.h"
#include "tests/support/eventually.h"
#include "tests/support/fake_server/fake_server.h"
#include "tests/support/status_assertions.h"
#include "tests/support/test_data.h"

namespace enfilade::robot {
namespace {

using client::Spool;
using client::SpoolItem;
using client::SpoolSession;
using ::testing::Contains;
using ::testing::ElementsAre;
using testing::FakeServer;
using ::testing::HasSubstr;
using testing::TemporaryDirectory;

// The drive of figure 1, with small pictures.
simulator::SimulationOptions SmallPictures() {
  simulator::SimulationOptions options;
  options.image_hz = 2.0;
  options.cloud_hz = 1.0;
  options.near_doors = 4.5;
  options.camera.width = 64;
  options.camera.height = 48;
  options.cloud.azimuths = 60;
  return options;
}

class AgentTest : public ::testing::Test {
 protected:
  AgentTest() { OpenSpool({}); }

  void OpenSpool(const client::SpoolOptions& options) {
    agent_.reset();
    uploader_.reset();
    spool_.reset();
    spool_ = *Spool::Open((directory_.path() / "robot.spool").string(), options);
    UploaderOptions uploader_options;
    uploader_options.uplink.min_backoff_s = 0.001;
    uploader_options.uplink.max_backoff_s = 0.02;
    uploader_options.follow_s = 0.05;
    uploader_ = std::make_unique<Uploader>(connection_, *spool_, convert::RobotName{SiteId("s"), RobotId("r1")},
                                           Listener(), uploader_options);
  }
  NotificationListener Listener() {
    return [this](const Notification& notification) {
      MutexLock lock(mutex_);
      notifications_.push_back(notification);
    };
  }
  absl::Status MakeAgent(const RobotOptions& options = {}) {
    AgentSetup setup;
    setup.site = SiteId("s");
    setup.robot = RobotId("r1");
    setup.source = "a test";
    setup.options = options;
    setup.start = RecordNewMap{"Hall"};
    absl::StatusOr<std::unique_ptr<Agent>> agent =
        Agent::Make(std::move(setup), {connection_, *spool_, *uploader_, Listener(), [this] { return interrupted_; }});
    if (!agent.ok()) return agent.status();
    agent_ = *std::move(agent);
    return absl::OkStatus();
  }
  // The events' names so far.
  std::vector<std::string> Events() {
    MutexLock lock(mutex_);
    std::vector<std::string> events;
    for (const Notification& notification : notifications_) events.push_back(notification.event);
    return events;
  }
  std::vector<sensor::Record> RecordsOf(const SessionId& session) {
    std::vector<sensor::Record> records;
    while (true) {
      const auto batch = spool_->ReadBatch(session, records.empty() ? 0 : records.back().sequence, 1000, 64LL << 20);
      EXPECT_OK(batch.status());
      if (!batch.ok() || batch->empty()) return records;
      records.insert(records.end(), batch->begin(), batch->end());
    }
  }
  static SpoolItem OdometryAt(double seconds, double x) {
    return {sensor::Odometry{static_cast<TimeNs>(seconds * 1e9), {x, 0.0, 0.0}}, {}};
  }
  static SpoolItem ScanAt(double seconds, float range = 4.0F, int beams = 90) {
    sensor::LaserScan scan;
    scan.time = static_cast<TimeNs>(seconds * 1e9);
    scan.angle_min = -M_PI;
    scan.angle_increment = 2.0 * M_PI / beams;
    scan.range_min = 0.1F;
    scan.range_max = 30.0F;
    scan.ranges.assign(static_cast<std::size_t>(beams), range);
    return {scan, {}};
  }
  // The robot stands in a round room for `seconds`.
  absl::Status Stand(double from, double seconds) {
    for (int i = 0; i < static_cast<int>(seconds * 10.0); ++i) {
      for (const SpoolItem& item : {OdometryAt(from + 0.1 * i, 0.0), ScanAt(from + 0.1 * i)}) {
        if (absl::Status status = agent_->Add(item); !status.ok()) return status;
      }
    }
    return absl::OkStatus();
  }

  TemporaryDirectory directory_;
  Mutex mutex_;
  std::vector<Notification> notifications_;
  bool interrupted_ = false;
  client::Connection connection_{"unix:" + (directory_.path() / "server").string(), std::chrono::seconds(5)};
  std::unique_ptr<Spool> spool_;
  std::unique_ptr<Uploader> uploader_;
  std::unique_ptr<Agent> agent_;
};

int CountOf(const std::vector<sensor::Record>& records, sensor::RecordKind kind) {
  return static_cast<int>(std::count_if(records.begin(), records.end(),
                                        [&](const sensor::Record& record) { return sensor::KindOf(record) == kind; }));
}

class CarriedTest : public AgentTest {
 protected:
  CarriedTest() {
    RobotOptions options;
    options.spool.wait_when_full = false;  // nobody answers where the robot is
    EXPECT_OK(MakeAgent(options));
    EXPECT_OK(agent_->Start());
  }
  // Ten scans a second in a round room of that radius, while odometry says that the robot moves slowly.
  void See(int scans, float radius) {
    for (int i = 0; i < scans; ++i) {
      time_ += 0.1;
      ASSERT_OK(agent_->Add(OdometryAt(time_, 0.05 * time_)));
      ASSERT_OK(agent_->Add(ScanAt(time_, radius, 360)));
    }
  }
  // The ranges of the scans of each session, one a scan.
  std::vector<std::vector<float>> Recorded() {
    EXPECT_OK(agent_->Finish());
    std::vector<std::vector<float>> sessions;
    for (const SpoolSession& session : spool_->ListSessions()) {
      std::vector<float>& ranges = sessions.emplace_back();
      TimeNs last = 0;
      for (const sensor::Record& record : RecordsOf(session.id)) {
        EXPECT_GE(sensor::TimeOf(record.payload), last) << "in order";
        last = sensor::TimeOf(record.payload);
        if (const auto* scan = std::get_if<sensor::LaserScan>(&record.payload)) ranges.push_back(scan->ranges[0]);
      }
    }
    return sessions;
  }
  double time_ = 0.0;
};

TEST_F(CarriedTest, NothingOfWhatContradictsIsRecorded) {
  See(60, 4.0F);
  See(20, 1.0F);
  const std::vector<std::vector<float>> sessions = Recorded();
  ASSERT_EQ(sessions.size(), 2U);
  EXPECT_THAT(sessions[0], ::testing::Each(4.0F));
  EXPECT_EQ(sessions[0].size(), 60U);
  EXPECT_THAT(sessions[1], ::testing::Each(1.0F));
}

TEST_F(CarriedTest, AFewOddScansAreRecordedInTheirPlaces) {
  See(60, 4.0F);
  See(3, 1.0F);
  See(10, 4.0F);
  const std::vector<std::vector<float>> sessions = Recorded();
  ASSERT_EQ(sessions.size(), 1U);
  ASSERT_EQ(sessions[0].size(), 73U);
  EXPECT_EQ(std::count(sessions[0].begin() + 60, sessions[0].begin() + 63, 1.0F), 3);
}

TEST_F(CarriedTest, OddScansAtTheEndAreRecorded) {
  See(60, 4.0F);
  See(2, 1.0F);
  const std::vector<std::vector<float>> sessions = Recorded();
  ASSERT_EQ(sessions.size(), 1U);
  EXPECT_EQ(sessions[0].size(), 62U);
}

// The whole drive without a server: everything is in the spool.
TEST_F(AgentTest, SplitsTheCampusIntoSessionsAtItsDoors) {
  ASSERT_OK(MakeAgent());
  ASSERT_OK_AND_ASSIGN(simulator::Campus campus, simulator::LoadCampus("figure1"));
  ASSERT_OK_AND_ASSIGN(
      auto simulation,
      simulator::RobotSimulation::Start(std::make_shared<simulator::World>(std::move(campus)), "r1", SmallPictures()));
  ASSERT_OK(agent_->Start());
  std::int64_t scans = 0;
  while (true) {
    ASSERT_OK_AND_ASSIGN(auto record, simulation.Next());
    if (!record) break;
    scans += std::holds_alternative<sensor::LaserScan>(record->payload) ? 1 : 0;
    ASSERT_OK(agent_->Add({record->payload, record->content}));
  }
  ASSERT_OK(agent_->Finish());
  EXPECT_EQ(agent_->state(), State::kEnd);

  const std::vector<SpoolSession> sessions = spool_->ListSessions();
  const std::vector<simulator::TruePassage>& truth = simulation.truth().passages;
  ASSERT_EQ(sessions.size(), truth.size() + 1);
  std::int64_t scans_recorded = 0;
  int candidates = 0;
  for (std::size_t i = 0; i < sessions.size(); ++i) {
    EXPECT_TRUE(sessions[i].finished);
    EXPECT_EQ(sessions[i].map, i == 0 ? "Hall" : "");
    EXPECT_EQ(sessions[i].entry.previous, i == 0 ? std::nullopt : std::optional(sessions[i - 1].id));
    const std::vector<sensor::Record> records = RecordsOf(sessions[i].id);
    scans_recorded += CountOf(records, sensor::RecordKind::kLaserScan);
    candidates += CountOf(records, sensor::RecordKind::kDoorReport) - (i < truth.size() ? 1 : 0);
    if (i == truth.size()) continue;
    ASSERT_TRUE(std::holds_alternative<sensor::DoorReport>(records.back().payload)) << "the passage ends the session";
    const auto& report = std::get<sensor::DoorReport>(records.back().payload);
    EXPECT_EQ(report.kind, sensor::DoorReport::Kind::kPassage);
    EXPECT_NEAR(ToSeconds(report.door_time - truth[i].time), 0.0, 1.0) << truth[i].door;
    EXPECT_EQ(report.entered_environment,
              truth[i].to == "M1" || truth[i].to == "M3" ? Environment::kOutdoor : Environment::kIndoor)
        << truth[i].door;
    EXPECT_GE(CountOf(records, sensor::RecordKind::kImage), 8) << truth[i].door;
    EXPECT_GE(CountOf(records, sensor::RecordKind::kPointCloud), 2) << truth[i].door;
  }
  EXPECT_EQ(scans_recorded, scans);
  EXPECT_EQ(candidates, 2) << "the doors that were only seen from inside";
}

TEST_F(AgentTest, UploadsEverythingThroughAnOutage) {
  FakeServer server("unix:" + (directory_.path() / "server").string());
  ASSERT_OK(MakeAgent());
  uploader_->Start();
  ASSERT_OK(agent_->Start());
  ASSERT_OK(Stand(1.0, 20.0));
  ASSERT_OK(agent_->Do(SetLinkPoint{}));
  server.Stop();
  ASSERT_OK(Stand(21.0, 20.0));
  ASSERT_OK(agent_->Do(SetLinkPoint{}));
  ASSERT_OK(Stand(41.0, 5.0));
  ASSERT_OK(agent_->Finish());
  EXPECT_FALSE(uploader_->Done(false));
  server.Start();
  ASSERT_TRUE(testing::Eventually([&] { return uploader_->Done(false); })) << uploader_->progress().blocked;
  uploader_->Stop();

  const auto sessions = server.sessions();
  ASSERT_EQ(sessions.size(), 3U);
  std::size_t records = 0;
  int chained = 0;
  for (const auto& [name, session] : sessions) {
    EXPECT_TRUE(session.finished);
    EXPECT_EQ(session.conflicts, 0);
    records += session.records.size();
    if (!session.session.entry().previous_session().empty()) {
      ++chained;
      EXPECT_TRUE(sessions.contains(session.session.entry().previous_session()));
    }
  }
  EXPECT_EQ(chained, 2);
  EXPECT_EQ(records, static_cast<std::size_t>(agent_->counts().records));
  EXPECT_TRUE(spool_->ListSessions().empty()) << "uploaded sessions are removed from the spool";
}

TEST_F(AgentTest, FinishesWhatAnEarlierRunLeftOpenAndBeginsANewSession) {
  ASSERT_OK(MakeAgent());
  ASSERT_OK(agent_->Start());
  ASSERT_OK(Stand(1.0, 5.0));
  std::this_thread::sleep_for(std::chrono::milliseconds(250));
  ASSERT_OK(agent_->Flush());
  const SpoolSession left = spool_->ListSessions().at(0);
  EXPECT_FALSE(left.finished);
  EXPECT_EQ(left.last_sequence, 100);

  OpenSpool({});  // the program was killed, and starts again
  ASSERT_OK(MakeAgent());
  ASSERT_OK(agent_->Start());
  EXPECT_THAT(Events(), Contains("leftover"));
  ASSERT_OK(Stand(6.0, 1.0));
  const std::vector<SpoolSession> sessions = spool_->ListSessions();
  ASSERT_EQ(sessions.size(), 2U);
  EXPECT_TRUE(sessions[0].finished);
  EXPECT_EQ(sessions[0].last_sequence, 100);
  EXPECT_FALSE(sessions[1].finished);
  EXPECT_EQ(sessions[1].entry.previous, std::nullopt);
}

TEST_F(AgentTest, RefusesAnotherRobotsSpool) {
  SpoolSession other;
  other.site = SiteId("s");
  other.robot = RobotId("r2");
  other.id = SessionId("x");
  ASSERT_OK(spool_->CreateSession(other));
  EXPECT_STATUS(MakeAgent(), absl::StatusCode::kFailedPrecondition, HasSubstr("r2"));
}

TEST_F(AgentTest, RefusesScansButNoReportsWhileTheSpoolIsFull) {
  client::SpoolOptions small;
  small.max_bytes = 64 << 10;
  OpenSpool(small);
  RobotOptions options;
  options.spool.wait_when_full = false;
  ASSERT_OK(MakeAgent(options));
  ASSERT_OK(agent_->Start());
  ASSERT_OK(Stand(1.0, 30.0));
  EXPECT_GT(agent_->counts().refused, 0);
  EXPECT_THAT(Events(), Contains("spool_full"));
  ASSERT_OK(agent_->Do(SetCandidate{}));
  const std::vector<sensor::Record> records = RecordsOf(spool_->ListSessions().at(0).id);
  EXPECT_EQ(CountOf(records, sensor::RecordKind::kDoorReport), 1);
  EXPECT_EQ(agent_->counts().records, static_cast<std::int64_t>(records.size()));
}

TEST_F(AgentTest, WaitsForSpaceIfConfigured) {
  client::SpoolOptions small;
  small.max_bytes = 64 << 10;
  OpenSpool(small);
  ASSERT_OK(MakeAgent());
  ASSERT_OK(agent_->Start());
  interrupted_ = true;  // at the first wait: nobody frees space here
  EXPECT_STATUS(Stand(1.0, 60.0), absl::StatusCode::kCancelled, HasSubstr("full"));
  EXPECT_EQ(agent_->counts().refused, 0);
}

TEST_F(AgentTest, ReportsAndCountsInvalidInput) {
  ASSERT_OK(MakeAgent());
  ASSERT_OK(agent_->Start());
  SpoolItem broken = ScanAt(2.0);
  std::get<sensor::LaserScan>(broken.payload).ranges.clear();
  EXPECT_OK(agent_->Add(broken));
  const std::string content = "not what the record says";
  EXPECT_OK(agent_->Add(
      {sensor::Image{kNsPerSecond, sensor::Camera::kFront, sensor::ImageEncoding::kPng, sources::RefOf("other")},
       content}));
  EXPECT_OK(agent_->Add({sensor::DoorReport{}, {}}));
  EXPECT_EQ(agent_->counts().invalid, 3);
  EXPECT_THAT(Events(), Contains("bad_input"));
  ASSERT_OK(Stand(3.0, 2.0));
  EXPECT_EQ(agent_->state(), State::kMapping);
}

TEST_F(AgentTest, RecordsImagesEverywhereAtTheRequestedRate) {
  RobotOptions options;
  options.evidence.all_hz = 1.0;
  ASSERT_OK(MakeAgent(options));
  ASSERT_OK(agent_->Start());
  ASSERT_OK(agent_->Add(ScanAt(1.0)));
  for (int i = 0; i < 100; ++i) {
    const std::string content = "image " + std::to_string(i);
    const TimeNs time = kNsPerSecond + i * kNsPerSecond / 10;
    ASSERT_OK(agent_->Add(
        {sensor::Image{time, sensor::Camera::kFront, sensor::ImageEncoding::kPng, sources::RefOf(content)}, content}));
  }
  ASSERT_OK(agent_->Finish());
  const std::vector<sensor::Record> records = RecordsOf(spool_->ListSessions().at(0).id);
  EXPECT_NEAR(CountOf(records, sensor::RecordKind::kImage), 10, 1);
}

TEST_F(AgentTest, BeginsNoSessionWithoutAScan) {
  ASSERT_OK(MakeAgent());
  ASSERT_OK(agent_->Start());
  ASSERT_OK(agent_->Add(OdometryAt(1.0, 0.0)));
  EXPECT_EQ(agent_->state(), State::kStartMapping);
  ASSERT_OK(agent_->Finish());
  EXPECT_EQ(agent_->state(), State::kEnd);
  EXPECT_TRUE(spool_->ListSessions().empty());
}

TEST_F(AgentTest, RecordsNothingInTheMainMenu) {
  RobotOptions options;
  options.automatic = false;
  ASSERT_OK(MakeAgent(options));
  ASSERT_OK(agent_->Start());
  ASSERT_OK(Stand(1.0, 3.0));
  EXPECT_TRUE(spool_->ListSessions().empty());
  EXPECT_EQ(agent_->counts().ignored, 60);
  ASSERT_OK(agent_->Do(RecordNewMap{"By hand"}));
  ASSERT_OK(Stand(4.0, 3.0));
  ASSERT_OK(agent_->Do(StopMapping{}));
  EXPECT_EQ(agent_->state(), State::kMainMenu);
  EXPECT_EQ(spool_->ListSessions().at(0).last_sequence, 60);
  EXPECT_EQ(spool_->ListSessions().at(0).map, "By hand");
}

}  // namespace
}  // namespace enfilade::robot
