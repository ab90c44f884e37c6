// SPDX-License-Identifier: Apache-2.0
#include "client/sdk/uplink/uplink.h"

#include <atomic>
#include <thread>

#include "tests/support/fake_server/cutting_proxy.h"
#include "tests/unit/client/uplink/uplink_fixture.h"

namespace enfilade::client {
namespace {

using testing::CuttingProxy;
using testing::FakeServer;
using ::testing::HasSubstr;
using testing::kRun;
using testing::Moment;
using testing::UplinkTest;

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

TEST_F(UplinkTest, WaitsForAServerThatIsSlowToAnswerWhenItConnects) {
  Serve();
  RecordAll(100);
  CuttingProxy proxy((directory_.path() / "proxy").string(), (directory_.path() / "server").string(),
                     {{.delay = std::chrono::seconds(2)}});
  ASSERT_OK(Bring(proxy.address()));
  ExpectAllStored();
  EXPECT_EQ(proxy.connections(), 1) << "given up and begun anew";
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
    EXPECT_CODE(uplink.WaitFor(std::chrono::seconds(0)).value(), absl::StatusCode::kCancelled);
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
  EXPECT_CODE(uplink.WaitFor(std::chrono::seconds(0)).value(), absl::StatusCode::kCancelled);
}

TEST_F(UplinkTest, ReportsWhichMapWasEnteredAndReportsPoses) {
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
}  // namespace enfilade::client
