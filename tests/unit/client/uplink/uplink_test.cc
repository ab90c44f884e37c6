#include "client/cpp/uplink/uplink.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "proto/convert/record.h"
#include "tests/support/cutting_proxy.h"
#include "tests/support/fake_server.h"
#include "tests/support/status_matchers.h"
#include "tests/support/test_data.h"
#include "tests/unit/client/spool/spool_samples.h"

namespace enfilade {
namespace {

using client::Spool;
using client::SpoolItem;
using client::SpoolSession;
using testing::CuttingProxy;
using testing::FakeServer;
using testing::HasCode;
using testing::HasStatus;
using ::testing::HasSubstr;
using testing::ImageItem;
using testing::Moment;
using testing::NumberedScan;
using testing::SampleSession;
using testing::TemporaryDirectory;

const SessionId kRun("run-1");
constexpr const char* kRunName = "sites/campus/sessions/run-1";

// A spool with a session, and a server to bring it to.
class UplinkTest : public ::testing::Test {
 protected:
  UplinkTest() {
    spool_ = *Spool::Open((directory_.path() / "robot.spool").string());
    EXPECT_OK(spool_->CreateSession(SampleSession()));
    options_.min_backoff_s = 0.001;
    options_.max_backoff_s = 0.02;
    options_.stream.max_batch_records = 20;
  }

  void Serve(FakeServer::Behaviour behaviour = {}) {
    server_ = std::make_unique<FakeServer>("unix:" + (directory_.path() / "server").string(), std::move(behaviour));
  }
  // Appends items, each one unlike the others; every `image_every`-th is an image of `image_bytes`.
  void Record(int items, int image_every = 0, std::size_t image_bytes = 1000) {
    std::vector<SpoolItem> batch;
    for (int i = 0; i < items; ++i) {
      ++recorded_;
      if (image_every > 0 && recorded_ % image_every == 0) {
        batch.push_back(ImageItem(std::to_string(recorded_) + std::string(image_bytes, 'p')));
      } else {
        batch.push_back({NumberedScan(recorded_, 30), {}});
      }
    }
    ASSERT_OK(spool_->Append(kRun, batch));
  }
  void RecordAll(int items, int image_every = 0, std::size_t image_bytes = 1000) {
    Record(items, image_every, image_bytes);
    ASSERT_OK(spool_->MarkFinished(kRun));
  }
  // Brings everything over `address` and gives the outcome.
  absl::Status Bring(const std::string& address) {
    Uplink uplink(Connection(address, std::chrono::seconds(20)), *spool_, kRun, options_);
    uplink.Start();
    const auto result = uplink.WaitFor(std::chrono::minutes(2));
    progress_ = uplink.progress();
    return result.value_or(absl::DeadlineExceededError("the uplink has not come to an end"));
  }
  absl::Status Bring() { return Bring(server_->address()); }

  // The session is finished on the server and holds every record once, as it was recorded.
  void ExpectAllStored(const std::set<std::int64_t>& withheld = {}) {
    const auto sessions = server_->sessions();
    ASSERT_EQ(sessions.size(), 1U);
    const FakeServer::Session& session = sessions.begin()->second;
    EXPECT_TRUE(session.finished);
    EXPECT_EQ(session.conflicts, 0);
    ASSERT_EQ(session.records.size(), static_cast<std::size_t>(recorded_));
    for (const auto& [sequence, stored] : session.records) {
      if (withheld.contains(sequence)) {
        EXPECT_TRUE(stored.has_withheld());
      } else if (stored.has_laser_scan()) {
        ASSERT_EQ(*FromProto(stored), (enfilade::Record{sequence, NumberedScan(static_cast<int>(sequence), 30)}));
      } else {
        ASSERT_TRUE(stored.has_image());
        const std::string content = server_->blobs()[stored.image().content().sha256()];
        ASSERT_EQ(content.substr(0, content.find('p')), std::to_string(sequence));
      }
    }
    EXPECT_TRUE(spool_->FindSession(kRun)->closed);
    EXPECT_EQ(spool_->usage().records, 0);
  }

  TemporaryDirectory directory_;
  std::unique_ptr<Spool> spool_;
  std::unique_ptr<FakeServer> server_;
  UplinkOptions options_;
  UplinkProgress progress_;
  int recorded_ = 0;
};

TEST_F(UplinkTest, BringsEverythingOnce) {
  Serve();
  RecordAll(1000, 100);
  ASSERT_OK(Bring());
  ExpectAllStored();
  EXPECT_EQ(server_->records_received(), 1000);
  EXPECT_EQ(server_->robots(), std::set<std::string>{"sites/campus/robots/r1"});
  EXPECT_EQ(server_->maps().begin()->second, "hall");
  EXPECT_EQ(progress_.acknowledged_sequence, 1000);
}

TEST_F(UplinkTest, ClosesASessionWithoutRecords) {
  Serve();
  ASSERT_OK(spool_->MarkFinished(kRun));
  ASSERT_OK(Bring());
  ExpectAllStored();
}

TEST_F(UplinkTest, SendsWhatIsRecordedMeanwhile) {
  Serve();
  Uplink uplink(Connection(server_->address(), std::chrono::seconds(20)), *spool_, kRun, options_);
  uplink.Start();
  for (int i = 0; i < 50; ++i) Record(1 + i % 3);
  EXPECT_EQ(uplink.WaitFor(std::chrono::milliseconds(1)), std::nullopt);
  ASSERT_OK(spool_->MarkFinished(kRun));
  ASSERT_OK(uplink.WaitFor(std::chrono::minutes(2)).value());
  ExpectAllStored();
}

TEST_F(UplinkTest, SendsLargeBlobsInChunks) {
  Serve();
  RecordAll(4, 2, (3U << 20) + 17);
  ASSERT_OK(Bring());
  ExpectAllStored();
}

struct CutAt {
  const char* name;
  Moment moment;
};

class UplinkCut : public UplinkTest, public ::testing::WithParamInterface<CutAt> {};

// The call ends at this moment, several times over, with codes that proxies and dying servers give.
TEST_P(UplinkCut, LosesAndDoublesNothing) {
  constexpr grpc::StatusCode kCodes[] = {grpc::StatusCode::UNAVAILABLE, grpc::StatusCode::DEADLINE_EXCEEDED,
                                         grpc::StatusCode::INTERNAL,    grpc::StatusCode::CANCELLED,
                                         grpc::StatusCode::UNKNOWN,     grpc::StatusCode::RESOURCE_EXHAUSTED,
                                         grpc::StatusCode::ABORTED};
  FakeServer::Behaviour behaviour;
  std::atomic<int> cuts = 0;
  behaviour.interfere = [&](Moment moment, int count) {
    // The 1st, 3rd, 6th, 10th, ... time.
    const bool triangular = [count] {
      for (int n = 1, sum = 1; sum <= count; sum += ++n) {
        if (sum == count) return true;
      }
      return false;
    }();
    if (moment != GetParam().moment || !triangular || cuts >= 7) return grpc::Status::OK;
    return grpc::Status(kCodes[cuts++], "cut");
  };
  Serve(behaviour);
  RecordAll(600, 50);
  ASSERT_OK(Bring());
  ExpectAllStored();
  EXPECT_GT(cuts, 0) << "the cut never happened";
}

INSTANTIATE_TEST_SUITE_P(
    AtEveryKindOfMoment, UplinkCut,
    ::testing::Values(CutAt{"CreateSession", Moment::kCreateSession}, CutAt{"OpenReceived", Moment::kOpenReceived},
                      CutAt{"OpenedSent", Moment::kOpenedSent}, CutAt{"ChunkReceived", Moment::kChunkReceived},
                      CutAt{"BatchReceived", Moment::kBatchReceived}, CutAt{"BatchStored", Moment::kBatchStored},
                      CutAt{"Acknowledged", Moment::kAcknowledged}, CutAt{"HalfClosed", Moment::kHalfClosed},
                      CutAt{"FinishRequested", Moment::kFinishRequested}, CutAt{"Finished", Moment::kFinished}),
    [](const auto& param) { return param.param.name; });

// Connections cut at byte counts from the handshake's first byte on into the middle of batches and blobs.
TEST_F(UplinkTest, SurvivesCutsAtAnyByte) {
  Serve();
  RecordAll(600, 50, 5000);
  std::vector<CuttingProxy::Cut> cuts;
  for (const std::int64_t bytes : {1, 24, 30, 64, 150, 333, 600, 1000, 2001, 9000, 20'003, 70'001}) {
    cuts.push_back({bytes, -1});
    cuts.push_back({-1, std::max<std::int64_t>(bytes / 4, 1)});
  }
  const std::size_t planned = cuts.size();
  CuttingProxy proxy((directory_.path() / "proxy").string(), (directory_.path() / "server").string(), std::move(cuts));
  ASSERT_OK(Bring(proxy.address()));
  ExpectAllStored();
  EXPECT_GT(proxy.cuts_made(), 15) << "of " << planned;
}

TEST_F(UplinkTest, WaitsForAServerThatIsNotThereYet) {
  RecordAll(100);
  Uplink uplink(Connection("unix:" + (directory_.path() / "server").string(), std::chrono::seconds(20)), *spool_, kRun,
                options_);
  uplink.Start();
  while (uplink.progress().last_error.empty()) std::this_thread::yield();
  EXPECT_THAT(uplink.progress().last_error, HasSubstr("cannot be reached"));
  Serve();
  ASSERT_OK(uplink.WaitFor(std::chrono::minutes(2)).value());
  ExpectAllStored();
}

TEST_F(UplinkTest, GoesOnAfterTheServerWasStopped) {
  Serve();
  Record(100);
  Uplink uplink(Connection(server_->address(), std::chrono::seconds(20)), *spool_, kRun, options_);
  uplink.Start();
  for (int round = 0; round < 5; ++round) {
    while (uplink.progress().acknowledged_sequence < recorded_) std::this_thread::yield();
    server_->Stop();
    Record(50);
    server_->Start();
  }
  ASSERT_OK(spool_->MarkFinished(kRun));
  ASSERT_OK(uplink.WaitFor(std::chrono::minutes(2)).value());
  ExpectAllStored();
  EXPECT_GE(uplink.progress().connections, 6);
}

TEST_F(UplinkTest, GoesOnWhereAnotherUplinkEnded) {
  Serve();
  server_->HoldAcknowledgements(true);
  RecordAll(500);
  {
    Uplink uplink(Connection(server_->address(), std::chrono::seconds(20)), *spool_, kRun, options_);
    uplink.Start();
    while (server_->records_received() == 0) std::this_thread::yield();
    uplink.Stop();
    EXPECT_THAT(uplink.WaitFor(std::chrono::seconds(0)).value(), HasCode(absl::StatusCode::kCancelled));
  }
  server_->HoldAcknowledgements(false);
  ASSERT_OK(Bring());
  ExpectAllStored();
  EXPECT_LT(server_->records_received(), 1000) << "what the server had is sent once more only in part";
}

TEST_F(UplinkTest, SendsNoMoreThanItsWindowAhead) {
  Serve();
  server_->HoldAcknowledgements(true);
  options_.stream.max_batches_in_flight = 3;
  RecordAll(1000);
  Uplink uplink(Connection(server_->address(), std::chrono::seconds(20)), *spool_, kRun, options_);
  uplink.Start();
  while (uplink.progress().sent_sequence < 60) std::this_thread::yield();
  EXPECT_EQ(uplink.WaitFor(std::chrono::milliseconds(100)), std::nullopt);
  EXPECT_EQ(uplink.progress().sent_sequence, 60);
  server_->HoldAcknowledgements(false);
  ASSERT_OK(uplink.WaitFor(std::chrono::minutes(2)).value());
  ExpectAllStored();
}

TEST_F(UplinkTest, PutsRefusedRecordsAsideAndSendsTheRest) {
  const std::set<std::int64_t> bad = {1, 2, 77, 78, 110, 299, 300};
  FakeServer::Behaviour behaviour;
  behaviour.refuse = [&](const v1::Record& record) -> std::optional<std::string> {
    if (!bad.contains(record.sequence()) || record.has_withheld()) return std::nullopt;
    return "record " + std::to_string(record.sequence()) + ": I do not like it";
  };
  Serve(behaviour);
  RecordAll(300);
  ASSERT_OK(Bring());
  ExpectAllStored(bad);
  EXPECT_EQ(progress_.quarantined, 7);
  ASSERT_OK_AND_ASSIGN(const auto kept, spool_->ListQuarantined(kRun));
  ASSERT_EQ(kept.size(), bad.size());
  EXPECT_EQ(kept[2].record, (enfilade::Record{77, NumberedScan(77, 30)}));
  EXPECT_EQ(kept[2].reason, "record 77: I do not like it");
}

TEST_F(UplinkTest, EndsWhereEvenTheWithheldRecordIsRefused) {
  FakeServer::Behaviour behaviour;
  behaviour.refuse = [](const v1::Record& record) -> std::optional<std::string> {
    return record.sequence() == 30 ? std::optional<std::string>("never") : std::nullopt;
  };
  Serve(behaviour);
  RecordAll(100);
  EXPECT_THAT(Bring(), HasStatus(absl::StatusCode::kFailedPrecondition, HasSubstr("record 30 is refused (never)")));
}

TEST_F(UplinkTest, EndsWithThePermanentErrorsAndKeepsTheSpool) {
  FakeServer::Behaviour behaviour;
  behaviour.interfere = [](Moment moment, int count) {
    if (moment != Moment::kBatchReceived || count < 3) return grpc::Status::OK;
    return grpc::Status(grpc::StatusCode::FAILED_PRECONDITION, "the session is deleted");
  };
  Serve(behaviour);
  RecordAll(100);
  EXPECT_THAT(Bring(), HasStatus(absl::StatusCode::kFailedPrecondition, HasSubstr("the session is deleted")));
  EXPECT_EQ(spool_->FindSession(kRun)->last_sequence, 100);
  EXPECT_GE(spool_->usage().records, 60);
}

TEST_F(UplinkTest, EndsWhereAnotherRobotRecordsUnderTheSameSession) {
  Serve();
  RecordAll(10);
  ASSERT_OK(Bring());
  server_->Edit(kRunName, [](FakeServer::Session& session) { session.session.set_robot("sites/campus/robots/other"); });
  ASSERT_OK(spool_->RemoveSession(kRun));
  SpoolSession again = SampleSession();
  again.request_id = "99999999-2222-4333-8444-555555555555";
  ASSERT_OK(spool_->CreateSession(again));
  EXPECT_THAT(Bring(), HasStatus(absl::StatusCode::kAlreadyExists, HasSubstr("recorded by sites/campus/robots/other")));
}

TEST_F(UplinkTest, GoesOnWithANewDiskWhereTheServerHasMoreThanTheSpool) {
  Serve();
  Record(100);
  ASSERT_OK(spool_->MarkFinished(kRun));
  ASSERT_OK(Bring());
  // The same recording again, from a spool that knows of nothing.
  ASSERT_OK(spool_->RemoveSession(kRun));
  SpoolSession again = SampleSession();
  again.request_id = "99999999-2222-4333-8444-555555555555";
  ASSERT_OK(spool_->CreateSession(again));
  recorded_ = 0;
  RecordAll(150);
  ASSERT_OK(Bring());
  ExpectAllStored();
}

TEST_F(UplinkTest, EndsOnConflictingRecords) {
  Serve();
  Record(20);
  options_.create_missing = true;
  server_->Edit(kRunName, [](FakeServer::Session& session) {
    session.request_id = SampleSession().request_id;
    session.records[5] = ToProto(enfilade::Record{5, NumberedScan(999, 30)});
  });
  EXPECT_THAT(Bring(), HasStatus(absl::StatusCode::kAlreadyExists, HasSubstr("two robots")));
}

TEST_F(UplinkTest, EndsWhereTheServerHasLostWhatItAcknowledged) {
  Serve();
  Record(100);
  {
    Uplink uplink(Connection(server_->address(), std::chrono::seconds(20)), *spool_, kRun, options_);
    uplink.Start();
    while (spool_->usage().records > 0) std::this_thread::yield();
  }
  server_->Edit(kRunName, [](FakeServer::Session& session) { session.records.erase(50); });
  EXPECT_THAT(Bring(), HasStatus(absl::StatusCode::kDataLoss, HasSubstr("up to 49 but has acknowledged up to 100")));
}

TEST_F(UplinkTest, CreatesNothingWhereThatIsNotWanted) {
  Serve();
  options_.create_missing = false;
  RecordAll(5);
  EXPECT_THAT(Bring(), HasStatus(absl::StatusCode::kNotFound, HasSubstr("has no map \"hall\"")));
  EXPECT_TRUE(server_->maps().empty());
}

TEST_F(UplinkTest, FiftyReconnectsMakeOneSession) {
  Serve();
  Record(1);
  for (int i = 0; i < 50; ++i) {
    Uplink uplink(Connection(server_->address(), std::chrono::seconds(20)), *spool_, kRun, options_);
    uplink.Start();
    while (!uplink.progress().connected) std::this_thread::yield();
  }
  EXPECT_EQ(server_->sessions().size(), 1U);
  EXPECT_GE(server_->streams_opened(), 50);
}

TEST_F(UplinkTest, StopsWhileTheServerIsSilent) {
  Serve();
  server_->HoldAcknowledgements(true);
  Record(100);
  Uplink uplink(Connection(server_->address(), std::chrono::seconds(20)), *spool_, kRun, options_);
  uplink.Start();
  while (uplink.progress().sent_sequence == 0) std::this_thread::yield();
  uplink.Stop();
  EXPECT_THAT(uplink.WaitFor(std::chrono::seconds(0)).value(), HasCode(absl::StatusCode::kCancelled));
}

TEST_F(UplinkTest, TellsWhichMapWasEnteredAndReportsPoses) {
  FakeServer::Behaviour behaviour;
  behaviour.map_entered.emplace().set_map("sites/campus/maps/hall");
  behaviour.refuse_pose = [](const v1::PoseReport& report) {
    return report.map() == "elsewhere" ? std::optional<std::string>("no such map") : std::nullopt;
  };
  Serve(std::move(behaviour));
  Record(3);
  std::atomic<int> entered = 0;
  options_.on_map_entered = [&](const v1::MapEntered& map) {
    entered += map.map() == "sites/campus/maps/hall" ? 1 : 0;
  };
  Uplink uplink(Connection(server_->address(), std::chrono::seconds(20)), *spool_, kRun, options_);
  PoseWithCovariance pose;
  pose.pose = {1.0, 2.0, 0.5};
  uplink.ReportPose("sites/campus/maps/hall", {}, 1);  // before there is a stream: the newest is sent on it
  uplink.ReportPose("sites/campus/maps/hall", pose, 2 * kNsPerSecond);
  uplink.Start();
  const auto soon = [](const auto& condition) {
    for (int i = 0; i < 3000 && !condition(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return condition();
  };
  ASSERT_TRUE(soon([&] { return server_->pose_reports().size() == 1; }));
  EXPECT_EQ(server_->pose_reports()[0].pose_map_robot().pose().y(), 2.0);
  EXPECT_EQ(server_->pose_reports()[0].time().seconds(), 2);
  EXPECT_TRUE(soon([&] { return entered == 1; }));
  uplink.ReportPose("elsewhere", pose, 3);
  EXPECT_TRUE(soon([&] { return uplink.progress().poses_refused == 1; }));
  EXPECT_EQ(uplink.progress().pose_error, "no such map");
  ASSERT_OK(spool_->MarkFinished(kRun));
  EXPECT_EQ(uplink.WaitFor(std::chrono::minutes(1)), absl::OkStatus()) << "the stream goes on after a refused pose";
}

}  // namespace
}  // namespace enfilade
