// SPDX-License-Identifier: Apache-2.0
#include "client/robot/upload/uploader.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <vector>

#include "tests/support/eventually.h"
#include "tests/support/fake_server/fake_server.h"
#include "tests/support/status_assertions.h"
#include "tests/support/test_data.h"

namespace enfilade::robot {
namespace {

using client::SpoolSession;
using ::testing::ElementsAre;
using testing::Eventually;
using testing::FakeServer;
using ::testing::HasSubstr;
using testing::Moment;
using testing::TemporaryDirectory;

class UploaderTest : public ::testing::Test {
 protected:
  UploaderTest() {
    spool_ = *client::Spool::Open((directory_.path() / "robot.spool").string());
    options_.uplink.min_backoff_s = 0.001;
    options_.uplink.max_backoff_s = 0.02;
    options_.follow_s = 0.02;
  }
  ~UploaderTest() override {
    uploader_.reset();
    server_.reset();
  }

  void Serve(FakeServer::Behaviour behaviour = {}) {
    server_ = std::make_unique<FakeServer>(address_, std::move(behaviour));
  }
  void StartUploader() {
    uploader_ = std::make_unique<Uploader>(client::Connection(address_, std::chrono::seconds(60)), *spool_,
                                           convert::RobotName{SiteId("s"), RobotId("r1")}, Listener(), options_);
    uploader_->Start();
  }
  NotificationListener Listener() {
    return [this](const Notification& notification) {
      MutexLock lock(mutex_);
      notifications_.push_back(notification);
    };
  }
  // A session in the spool; not finished.
  SessionId Begin(const std::string& id, const std::string& map = "Hall") {
    SpoolSession session;
    session.site = SiteId("s");
    session.robot = RobotId("r1");
    session.id = SessionId(id);
    session.request_id = "request-" + id;
    session.map = map;
    EXPECT_OK(spool_->CreateSession(session));
    return session.id;
  }
  void Record(const SessionId& session, int count) {
    for (int i = 0; i < count; ++i) {
      const auto time = static_cast<TimeNs>(++recorded_) * kNsPerSecond;
      ASSERT_OK(spool_->Append(session, sensor::Odometry{time, {0.1 * recorded_, 0.0, 0.0}}));
    }
  }
  SessionId RecordWhole(const std::string& id, int count = 10) {
    const SessionId session = Begin(id);
    Record(session, count);
    EXPECT_OK(spool_->MarkFinished(session));
    return session;
  }
  static std::string NameOf(const SessionId& session) { return "sites/s/sessions/" + session.value(); }

  std::vector<Notification> Notifications(const std::string& event) {
    MutexLock lock(mutex_);
    std::vector<Notification> found;
    for (const Notification& one : notifications_) {
      if (one.event == event) found.push_back(one);
    }
    return found;
  }
  // The member `field` of all notifications of `event`.
  std::vector<std::string> Fields(const std::string& event, const char* field) {
    std::vector<std::string> values;
    for (const Notification& one : Notifications(event)) values.push_back(one.fields.at(field).get<std::string>());
    return values;
  }
  bool Done(bool judged = false) {
    return Eventually([&] { return uploader_->Done(judged); });
  }

  TemporaryDirectory directory_;
  const std::string address_ = "unix:" + (directory_.path() / "server").string();
  UploaderOptions options_;
  std::unique_ptr<client::Spool> spool_;
  std::unique_ptr<FakeServer> server_;
  std::unique_ptr<Uploader> uploader_;
  int recorded_ = 0;

  Mutex mutex_;
  std::vector<Notification> notifications_;
};

TEST_F(UploaderTest, UploadsSessionsInTheOrderInWhichTheyBegan) {
  for (const char* id : {"b", "c", "a"}) RecordWhole(id, 5);
  Serve();
  StartUploader();
  ASSERT_TRUE(Done());
  EXPECT_THAT(Fields("uploaded", "session"), ElementsAre("b", "c", "a"));
  const auto sessions = server_->sessions();
  ASSERT_EQ(sessions.size(), 3U);
  for (const auto& [name, session] : sessions) {
    EXPECT_TRUE(session.finished) << name;
    EXPECT_EQ(session.records.size(), 5U) << name;
    EXPECT_EQ(session.conflicts, 0) << name;
  }
  EXPECT_TRUE(spool_->ListSessions().empty()) << "uploaded sessions are removed from the spool";
  const Uploader::Progress progress = uploader_->progress();
  EXPECT_EQ(progress.session, "");
  EXPECT_EQ(progress.waiting, 0);
  EXPECT_EQ(progress.blocked, "");
}

TEST_F(UploaderTest, UploadsASessionWhileItIsRecorded) {
  Serve();
  const SessionId session = Begin("live");
  StartUploader();
  Record(session, 3);
  ASSERT_TRUE(Eventually([&] { return server_->sessions()[NameOf(session)].records.size() == 3; }));
  EXPECT_EQ(uploader_->progress().session, "live");
  EXPECT_FALSE(uploader_->Done(false)) << "its upload is open";
}

TEST_F(UploaderTest, IsDoneOnlyWhenTheServerHasEveryFinishedSession) {
  RecordWhole("a");
  StartUploader();
  EXPECT_FALSE(uploader_->Done(false)) << "there is no server";
  Serve();
  ASSERT_TRUE(Done());
  EXPECT_EQ(server_->sessions().size(), 1U);
}

TEST_F(UploaderTest, SurvivesOutagesAndReportsThemOnceEach) {
  Serve();
  const SessionId session = Begin("a");
  StartUploader();
  for (int outage = 0; outage < 3; ++outage) {
    Record(session, 4);
    const std::size_t records = 4U * static_cast<std::size_t>(outage + 1);
    ASSERT_TRUE(Eventually([&] { return server_->sessions()[NameOf(session)].records.size() == records; }));
    server_->Stop();
    const auto count = static_cast<std::size_t>(2 * outage + 1);
    ASSERT_TRUE(Eventually([&] { return Notifications("uplink").size() >= count; })) << "the outage is reported";
    server_->Start();
    ASSERT_TRUE(Eventually([&] {
      const auto uplink = Notifications("uplink");
      return !uplink.empty() && uplink.back().fields.at("error").is_null();
    })) << "and its end";
  }
  ASSERT_OK(spool_->MarkFinished(session));
  ASSERT_TRUE(Done());
  EXPECT_EQ(server_->sessions()[NameOf(session)].records.size(), 12U);
  EXPECT_EQ(server_->sessions()[NameOf(session)].conflicts, 0);
  EXPECT_THAT(Notifications("uplink").at(0).text, HasSubstr("nothing is lost"));
}

TEST_F(UploaderTest, ABlockedSessionIsTriedAgainOnceTheCauseIsMended) {
  RecordWhole("a");
  std::atomic<int> refusals{0};
  FakeServer::Behaviour behaviour;
  behaviour.interfere = [&](Moment moment, int) {
    return moment == Moment::kCreateSession && refusals++ < 3
               ? grpc::Status(grpc::StatusCode::PERMISSION_DENIED, "not this robot")
               : grpc::Status::OK;
  };
  Serve(behaviour);
  options_.retry_blocked_s = 0.01;
  StartUploader();
  ASSERT_TRUE(Done());
  EXPECT_EQ(Notifications("blocked").size(), 3U);
  EXPECT_EQ(uploader_->progress().blocked, "");
  EXPECT_EQ(server_->sessions().size(), 1U);
}

TEST_F(UploaderTest, ASessionThatIsRefusedForGoodBlocksTheLaterOnes) {
  RecordWhole("a");
  RecordWhole("b");
  FakeServer::Behaviour behaviour;
  behaviour.interfere = [](Moment moment, int) {
    return moment == Moment::kCreateSession ? grpc::Status(grpc::StatusCode::PERMISSION_DENIED, "not this robot")
                                            : grpc::Status::OK;
  };
  Serve(behaviour);
  StartUploader();
  ASSERT_TRUE(Eventually([&] { return !uploader_->progress().blocked.empty(); }));
  EXPECT_THAT(uploader_->progress().blocked, HasSubstr("not this robot"));
  const std::vector<Notification> blocked = Notifications("blocked");
  ASSERT_EQ(blocked.size(), 1U);
  EXPECT_EQ(blocked[0].fields.at("session"), "a");
  EXPECT_THAT(blocked[0].text, HasSubstr(spool_->path()));
  EXPECT_FALSE(uploader_->Done(false));
  uploader_->Stop();
  EXPECT_EQ(spool_->ListSessions().size(), 2U) << "nothing leaves the spool";
  EXPECT_TRUE(server_->sessions().empty());
}

TEST_F(UploaderTest, ANewUploaderContinuesWhereTheLastOneStopped) {
  const SessionId a = RecordWhole("a", 20);
  RecordWhole("b", 7);
  Serve();
  server_->HoldAcknowledgements(true);
  StartUploader();
  ASSERT_TRUE(Eventually([&] { return server_->records_received() > 0; }));
  uploader_.reset();
  EXPECT_FALSE(spool_->ListSessions().empty());
  server_->HoldAcknowledgements(false);
  StartUploader();
  ASSERT_TRUE(Done());
  EXPECT_EQ(server_->sessions()[NameOf(a)].records.size(), 20U);
  EXPECT_EQ(server_->sessions()[NameOf(a)].conflicts, 0);
  EXPECT_EQ(server_->sessions().size(), 2U);
}

TEST_F(UploaderTest, KeepsSessionsWithRefusedRecordsInTheSpool) {
  const SessionId session = RecordWhole("a", 3);
  FakeServer::Behaviour behaviour;
  behaviour.refuse = [](const v1::Record& record) {
    return record.has_odometry() && record.sequence() == 2 ? std::optional<std::string>("too odd") : std::nullopt;
  };
  Serve(behaviour);
  StartUploader();
  ASSERT_TRUE(Done());
  EXPECT_TRUE(server_->sessions()[NameOf(session)].records.at(2).has_withheld());
  const std::vector<SpoolSession> left = spool_->ListSessions();
  ASSERT_EQ(left.size(), 1U);
  EXPECT_TRUE(left[0].closed);
  ASSERT_OK_AND_ASSIGN(const auto quarantined, spool_->ListQuarantined(session));
  ASSERT_EQ(quarantined.size(), 1U);
  EXPECT_THAT(quarantined[0].reason, HasSubstr("too odd"));
}

TEST_F(UploaderTest, ReportsTheMapEnteredOnceWithItsPose) {
  FakeServer::Behaviour behaviour;
  v1::MapEntered entered;
  entered.set_map("sites/s/maps/m7");
  entered.set_map_display_name("Hall");
  v1::Pose2& pose = *entered.mutable_pose_map_robot()->mutable_pose();
  pose.set_x(1.5);
  pose.set_y(-2.0);
  pose.set_yaw(M_PI / 2.0);
  behaviour.map_entered = entered;
  Serve(behaviour);
  RecordWhole("a");
  StartUploader();
  ASSERT_TRUE(Done());
  uploader_->Stop();
  const std::vector<Notification> maps = Notifications("map");
  ASSERT_FALSE(maps.empty());
  EXPECT_EQ(maps[0].text, "entered the map \"Hall\" at x 1.50 m, y -2.00 m, yaw 90.0 deg");
  EXPECT_EQ(maps[0].fields.at("map"), "sites/s/maps/m7");
  EXPECT_EQ(maps[0].fields.at("pose_map_robot").at("x_m"), 1.5);
}

TEST_F(UploaderTest, SendsPosesWithTheOpenSessionAndReportsRefusals) {
  FakeServer::Behaviour behaviour;
  behaviour.refuse_pose = [](const v1::PoseReport& report) {
    return report.map().ends_with("nowhere") ? std::optional<std::string>("there is no such map") : std::nullopt;
  };
  Serve(behaviour);
  const SessionId session = Begin("a");
  Record(session, 1);
  StartUploader();
  const auto report = [&](const std::string& map) {
    uploader_->ReportPose(map, {{1.0, 2.0, 0.5}, Eigen::Matrix3d::Identity()}, 7 * kNsPerSecond);
  };
  ASSERT_TRUE(Eventually([&] {
    report("sites/s/maps/hall");
    return !server_->pose_reports().empty();
  }));
  EXPECT_EQ(server_->pose_reports().at(0).map(), "sites/s/maps/hall");
  ASSERT_TRUE(Eventually([&] {
    report("sites/s/maps/nowhere");
    return !Notifications("pose_refused").empty();
  }));
  EXPECT_THAT(Notifications("pose_refused").at(0).text, HasSubstr("there is no such map"));
}

TEST_F(UploaderTest, FollowsASessionUntilItIsMappedAndAllItsDoorsAreJudged) {
  Serve();
  const SessionId session = RecordWhole("a");
  StartUploader();
  uploader_->ExpectVerdicts(session, 2);
  ASSERT_TRUE(Done());
  EXPECT_FALSE(uploader_->Done(true)) << "it is not mapped";
  const std::string map = server_->maps().begin()->first;

  const auto verdict = [](v1::DoorVerdict::Decision decision, const std::string& reason) {
    v1::DoorVerdict result;
    result.set_decision(decision);
    result.set_link_point("sites/s/linkPoints/l1");
    result.set_reason(reason);
    return result;
  };
  server_->Edit(NameOf(session), [&](FakeServer::Session& edited) {
    edited.session.set_map(map);
    edited.session.set_state(v1::Session::STATE_MAPPED);
    edited.verdicts.push_back(verdict(v1::DoorVerdict::DECISION_CANDIDATE_MADE, "first"));
  });
  ASSERT_TRUE(Eventually([&] { return Notifications("verdict").size() == 1; }));
  EXPECT_EQ(Notifications("verdict")[0].text, "candidate made l1: first");
  ASSERT_TRUE(Eventually([&] { return Notifications("mapped").size() == 1; }));
  EXPECT_THAT(Notifications("mapped")[0].text, HasSubstr("\"Hall\""));
  EXPECT_FALSE(Notifications("mapped")[0].fields.at("failed"));
  EXPECT_FALSE(uploader_->Done(true)) << "the second verdict is missing";

  server_->Edit(NameOf(session), [&](FakeServer::Session& edited) {
    v1::DoorVerdict second = verdict(v1::DoorVerdict::DECISION_LINK_POINT_RECOGNISED, "");
    second.set_entered_map(map);
    v1::DoorComparison& comparison = *second.add_comparisons();
    comparison.set_link_point("sites/s/linkPoints/l1");
    comparison.set_image_matches(42);
    comparison.set_accepted(true);
    edited.verdicts.push_back(second);
  });
  ASSERT_TRUE(Done(true));
  const std::vector<Notification> verdicts = Notifications("verdict");
  ASSERT_EQ(verdicts.size(), 2U) << "each verdict is reported once";
  EXPECT_EQ(verdicts[1].text, "link point recognised l1, into \"Hall\"");
  EXPECT_EQ(verdicts[1].fields.at("decision"), "DECISION_LINK_POINT_RECOGNISED");
  EXPECT_EQ(verdicts[1].fields.at("comparisons").at(0).at("image_matches"), 42);
  EXPECT_EQ(Notifications("mapped").size(), 1U);
}

TEST_F(UploaderTest, WhereSitesAreSurveyedASessionIsDoneOnceItIsSurveyedWhateverItsVerdicts) {
  Serve({.surveys_sites = true});
  const SessionId session = RecordWhole("a");
  StartUploader();
  uploader_->ExpectVerdicts(session, 1);
  ASSERT_TRUE(Done());
  const std::string map = server_->maps().begin()->first;
  server_->Edit(NameOf(session), [&](FakeServer::Session& edited) {
    edited.session.set_map(map);
    edited.session.set_state(v1::Session::STATE_MAPPED);
    edited.verdicts.emplace_back();
  });
  ASSERT_TRUE(Eventually([&] { return Notifications("verdict").size() == 1; }));
  EXPECT_FALSE(uploader_->Done(true)) << "it is not surveyed";

  // The survey has cut it: its verdict is the other part's.
  server_->Edit(NameOf(session), [&](FakeServer::Session& edited) {
    edited.session.set_surveyed(true);
    edited.verdicts.clear();
  });
  EXPECT_TRUE(Done(true));
}

TEST_F(UploaderTest, ASessionThatCannotBeMappedIsDoneAndReported) {
  Serve();
  const SessionId session = RecordWhole("a");
  StartUploader();
  ASSERT_TRUE(Done());
  server_->Edit(NameOf(session), [&](FakeServer::Session& edited) {
    edited.session.set_map("sites/s/maps/unknown");
    edited.session.set_state(v1::Session::STATE_FAILED);
    edited.session.set_error("no scans");
  });
  ASSERT_TRUE(Done(true));
  const std::vector<Notification> mapped = Notifications("mapped");
  ASSERT_EQ(mapped.size(), 1U);
  EXPECT_EQ(mapped[0].text, "session a could not be mapped: no scans");
  EXPECT_TRUE(mapped[0].fields.at("failed"));
}

TEST_F(UploaderTest, StopsWhileTheServerIsDown) {
  RecordWhole("a");
  StartUploader();
  ASSERT_TRUE(Eventually([&] { return !Notifications("uplink").empty(); }));
  uploader_->Stop();
  EXPECT_EQ(spool_->ListSessions().size(), 1U);
  EXPECT_EQ(uploader_->progress().blocked, "");
}

}  // namespace
}  // namespace enfilade::robot
