// SPDX-License-Identifier: Apache-2.0
#include "client/robot/run.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/eventually.h"
#include "tests/support/fake_server/fake_server.h"
#include "tests/support/status_assertions.h"
#include "tests/support/test_data.h"

namespace enfilade::robot {
namespace {

using ::testing::Contains;
using testing::FakeServer;
using ::testing::HasSubstr;
using testing::TemporaryDirectory;

// Gives prepared inputs, then an error or the end.
class PreparedSource : public Source {
 public:
  absl::StatusOr<Input> Next() override {
    ++asked;
    if (before_next) before_next(asked);
    if (!inputs.empty()) {
      Input input = std::move(inputs.front());
      inputs.pop_front();
      return input;
    }
    if (!error.ok()) return error;
    return Input(Ended{});
  }

  std::deque<Input> inputs;
  absl::Status error;
  std::function<void(int)> before_next;
  int asked = 0;
};

class RunTest : public ::testing::Test {
 protected:
  RunTest() {
    spool_ = *client::Spool::Open((directory_.path() / "robot.spool").string());
    UploaderOptions options;
    options.uplink.min_backoff_s = 0.001;
    options.uplink.max_backoff_s = 0.02;
    options.follow_s = 0.02;
    uploader_ = std::make_unique<Uploader>(connection_, *spool_, convert::RobotName{SiteId("s"), RobotId("r1")},
                                           listener_, options);
    options_.status_s = 3600.0;
  }
  ~RunTest() override {
    uploader_.reset();
    for (const int end : ends_) {
      if (end >= 0) close(end);
    }
  }

  void MakeAgent(const RobotOptions& options = {}) {
    AgentSetup setup;
    setup.site = SiteId("s");
    setup.robot = RobotId("r1");
    setup.options = options;
    setup.start = RecordNewMap{"Hall"};
    absl::StatusOr<std::unique_ptr<Agent>> agent = Agent::Make(
        std::move(setup), {connection_, *spool_, *uploader_, listener_, [this] { return interrupted_.load(); }});
    ASSERT_OK(agent.status());
    agent_ = *std::move(agent);
  }
  absl::Status Go() {
    uploader_->Start();
    return robot::Run({*agent_, *uploader_, source_, commands_ ? &*commands_ : nullptr,
                       [this] { return interrupted_.load(); }, listener_},
                      options_);
  }
  // Commands that a person has typed; none follow.
  void Type(const std::string& lines) {
    ASSERT_EQ(pipe(ends_), 0);
    ASSERT_EQ(write(ends_[1], lines.data(), lines.size()), static_cast<ssize_t>(lines.size()));
    close(ends_[1]);
    ends_[1] = -1;
    commands_.emplace(ends_[0]);
  }
  void DriveFor(double seconds) {
    for (int i = 0; i < static_cast<int>(10.0 * seconds); ++i) {
      const auto time = static_cast<TimeNs>(1e9 + 1e8 * ++steps_);
      sensor::LaserScan scan;
      scan.time = time;
      scan.angle_min = -M_PI;
      scan.angle_increment = 2.0 * M_PI / 60.0;
      scan.range_min = 0.1F;
      scan.range_max = 30.0F;
      scan.ranges.assign(60, 4.0F);
      source_.inputs.emplace_back(client::SpoolItem{sensor::Odometry{time, {0.05 * steps_, 0.0, 0.0}}, {}});
      source_.inputs.emplace_back(client::SpoolItem{scan, {}});
    }
  }
  std::vector<std::string> Events() {
    MutexLock lock(mutex_);
    std::vector<std::string> events;
    for (const Notification& one : notifications_) events.push_back(one.event);
    return events;
  }
  std::string TextOf(const std::string& event) {
    MutexLock lock(mutex_);
    for (const Notification& one : notifications_) {
      if (one.event == event) return one.text;
    }
    return "";
  }

  TemporaryDirectory directory_;
  Mutex mutex_;
  std::vector<Notification> notifications_;
  const NotificationListener listener_ = [this](const Notification& notification) {
    MutexLock lock(mutex_);
    notifications_.push_back(notification);
  };
  std::atomic<bool> interrupted_ = false;
  client::Connection connection_{"unix:" + (directory_.path() / "server").string(), std::chrono::seconds(60)};
  std::unique_ptr<client::Spool> spool_;
  std::unique_ptr<Uploader> uploader_;
  std::unique_ptr<Agent> agent_;
  PreparedSource source_;
  RunOptions options_;
  std::optional<LineReader> commands_;
  int ends_[2] = {-1, -1};
  int steps_ = 0;
};

TEST_F(RunTest, RecordsAndUploadsTheWholeSource) {
  FakeServer server("unix:" + (directory_.path() / "server").string());
  MakeAgent();
  DriveFor(5.0);
  ASSERT_OK(Go());
  EXPECT_EQ(agent_->state(), State::kEnd);
  EXPECT_EQ(agent_->counts().records, 100);
  const auto sessions = server.sessions();
  ASSERT_EQ(sessions.size(), 1U);
  EXPECT_EQ(sessions.begin()->second.records.size(), 100U);
  EXPECT_TRUE(sessions.begin()->second.finished);
}

TEST_F(RunTest, ReportsBadInputAndContinues) {
  FakeServer server("unix:" + (directory_.path() / "server").string());
  MakeAgent();
  DriveFor(1.0);
  source_.inputs.emplace_back(BadInput{"line 3: not valid JSON"});
  DriveFor(1.0);
  ASSERT_OK(Go());
  EXPECT_EQ(TextOf("bad_input"), "line 3: not valid JSON");
  EXPECT_EQ(agent_->counts().records, 40);
}

TEST_F(RunTest, AnErrorOfTheSourceEndsTheRunButKeepsWhatWasRecorded) {
  FakeServer server("unix:" + (directory_.path() / "server").string());
  MakeAgent();
  DriveFor(2.0);
  source_.error = absl::DataLossError("the log is damaged");
  EXPECT_STATUS(Go(), absl::StatusCode::kDataLoss, HasSubstr("damaged"));
  EXPECT_EQ(agent_->state(), State::kEnd);
  const auto sessions = server.sessions();
  ASSERT_EQ(sessions.size(), 1U) << "the session is finished and uploaded before the run ends";
  EXPECT_EQ(sessions.begin()->second.records.size(), 40U);
  EXPECT_TRUE(sessions.begin()->second.finished);
}

TEST_F(RunTest, AnInterruptFinishesTheSessionInTheSpool) {
  MakeAgent();
  DriveFor(5.0);
  source_.before_next = [this](int asked) {
    if (asked == 41) interrupted_ = true;
  };
  EXPECT_CODE(Go(), absl::StatusCode::kCancelled);
  const std::vector<client::SpoolSession> sessions = spool_->ListSessions();
  ASSERT_EQ(sessions.size(), 1U);
  EXPECT_TRUE(sessions[0].finished);
  EXPECT_EQ(sessions[0].last_sequence, 41);
}

TEST_F(RunTest, EndsInTheMainMenuIfNobodyCanChoose) {
  FakeServer server("unix:" + (directory_.path() / "server").string());
  RobotOptions options;
  options.automatic = false;
  MakeAgent(options);
  DriveFor(1.0);
  ASSERT_OK(Go());
  EXPECT_EQ(agent_->state(), State::kEnd);
  EXPECT_EQ(source_.asked, 0) << "the source is paused in the main menu";
  EXPECT_TRUE(server.sessions().empty());
}

TEST_F(RunTest, TakesTypedCommandsAndSkipsEmptyLines) {
  FakeServer server("unix:" + (directory_.path() / "server").string());
  RobotOptions options;
  options.automatic = false;
  MakeAgent(options);
  DriveFor(1.0);
  Type("\n  \nfly\nnew \"My hall\"\n");
  ASSERT_OK(Go());
  EXPECT_THAT(TextOf("bad_input"), HasSubstr("\"fly\" is not a command"));
  EXPECT_THAT(TextOf("session"), HasSubstr("into \"My hall\""));
  EXPECT_EQ(agent_->counts().records, 20);
}

TEST_F(RunTest, ALiveSourceIsReadInTheMainMenuToo) {
  FakeServer server("unix:" + (directory_.path() / "server").string());
  RobotOptions options;
  options.automatic = false;
  MakeAgent(options);
  options_.live = true;
  DriveFor(1.0);
  source_.inputs.emplace_back(Command(RecordNewMap{"Late"}));
  DriveFor(1.0);
  ASSERT_OK(Go());
  EXPECT_EQ(agent_->counts().ignored, 21) << "the source cannot wait, and odometry alone begins no session";
  EXPECT_EQ(agent_->counts().records, 20) << "with that odometry";
}

TEST_F(RunTest, FailsIfTheServerRefusesASessionForGood) {
  FakeServer::Behaviour behaviour;
  behaviour.interfere = [](testing::Moment moment, int) {
    return moment == testing::Moment::kCreateSession
               ? grpc::Status(grpc::StatusCode::PERMISSION_DENIED, "not this robot")
               : grpc::Status::OK;
  };
  FakeServer server("unix:" + (directory_.path() / "server").string(), behaviour);
  MakeAgent();
  DriveFor(1.0);
  EXPECT_STATUS(Go(), absl::StatusCode::kFailedPrecondition, HasSubstr("not this robot"));
  EXPECT_EQ(spool_->ListSessions().size(), 1U);
}

TEST_F(RunTest, ShowsItsStatusFromTimeToTime) {
  FakeServer server("unix:" + (directory_.path() / "server").string());
  MakeAgent();
  options_.status_s = 0.0;
  DriveFor(1.0);
  ASSERT_OK(Go());
  EXPECT_THAT(Events(), Contains("status"));
  EXPECT_THAT(TextOf("status"), HasSubstr("sessions"));
}

TEST_F(RunTest, IgnoresIdleMomentsOfTheSource) {
  FakeServer server("unix:" + (directory_.path() / "server").string());
  MakeAgent();
  for (int i = 0; i < 5; ++i) source_.inputs.emplace_back(Idle{});
  DriveFor(1.0);
  source_.inputs.emplace_back(Idle{});
  source_.inputs.emplace_back(PoseReport{"hall", {}, 5});
  ASSERT_OK(Go());
  EXPECT_EQ(agent_->counts().records, 20);
  EXPECT_EQ(agent_->counts().invalid, 0);
}

}  // namespace
}  // namespace enfilade::robot
