// SPDX-License-Identifier: Apache-2.0
// What all calls have in common: request ids, cancellation, deadlines, actors.
#include <atomic>
#include <chrono>
#include <thread>

#include "enfilade/v1/graph_service.grpc.pb.h"
#include "enfilade/v1/link_point_service.grpc.pb.h"
#include "enfilade/v1/localization_service.grpc.pb.h"
#include "enfilade/v1/map_area_service.grpc.pb.h"
#include "enfilade/v1/map_edit_service.grpc.pb.h"
#include "enfilade/v1/prior_map_service.grpc.pb.h"
#include "enfilade/v1/raster_service.grpc.pb.h"
#include "enfilade/v1/server_service.grpc.pb.h"
#include "enfilade/v1/watch_service.grpc.pb.h"
#include "google/protobuf/descriptor.h"
#include "grpcpp/generic/generic_stub.h"
#include "storage/postgres/driver/transaction.h"
#include "tests/rpc/server_test.h"

namespace enfilade::testing {
namespace {

using std::chrono::seconds;

class CallsTest : public ServerTest {
 protected:
  static std::string RequestIdIn(const grpc::ClientContext& context) {
    const auto& metadata = context.GetServerInitialMetadata();
    const auto found = metadata.find("x-request-id");
    return found == metadata.end() ? "" : std::string(found->second.data(), found->second.size());
  }

  // Whether `count` comes to be the number of statements that wait for a lock.
  bool AwaitLockWaits(const std::string& count) const {
    for (int i = 0; i < 3000; ++i) {
      if (database_.SqlValue("SELECT count(*) FROM pg_stat_activity"
                             " WHERE datname = current_database() AND wait_event_type = 'Lock'") == count) {
        return true;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
  }

  // Holds the row of site "s" against changes until it is destroyed.
  storage::postgres::Transaction LockSite() {
    static constexpr storage::postgres::Statement kLockSite{
        "locking the site", "SELECT site_id FROM enfilade.sites WHERE site_id = 's' FOR NO KEY UPDATE"};
    auto transaction = storage::postgres::Transaction::Begin(*pool_, Soon());
    EXPECT_OK(transaction);
    EXPECT_OK(transaction->Execute(kLockSite, storage::postgres::Params()));
    return *std::move(transaction);
  }

  grpc::Status RenameSite(grpc::ClientContext& context, const std::string& name) const {
    v1::UpdateSiteRequest request;
    request.mutable_site()->set_name("sites/s");
    request.mutable_site()->set_display_name(name);
    v1::UpdateSiteResponse response;
    return v1::SiteService::NewStub(connection_->channel())->UpdateSite(&context, request, &response);
  }
  std::string SiteName() const { return database_.SqlValue("SELECT display_name FROM enfilade.sites"); }
};

TEST_F(CallsTest, ACancelledCallFreesItsStatement) {
  auto lock = std::make_unique<storage::postgres::Transaction>(LockSite());
  grpc::ClientContext context;
  grpc::Status status;
  std::thread client([&] { status = RenameSite(context, "Renamed"); });
  EXPECT_TRUE(AwaitLockWaits("1"));
  context.TryCancel();
  client.join();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::CANCELLED);
  EXPECT_TRUE(AwaitLockWaits("0")) << "while the lock is still held";
  lock.reset();
  EXPECT_EQ(SiteName(), "Site");
  grpc::ClientContext again;
  EXPECT_TRUE(RenameSite(again, "Renamed").ok());
  EXPECT_EQ(SiteName(), "Renamed");
}

TEST_F(CallsTest, TheClientsDeadlineEndsTheStatement) {
  const auto lock = LockSite();
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::milliseconds(300));
  EXPECT_EQ(RenameSite(context, "Renamed").error_code(), grpc::StatusCode::DEADLINE_EXCEEDED);
  EXPECT_TRUE(AwaitLockWaits("0"));
}

TEST_F(CallsTest, TheDefaultDeadlineEndsAStatementWhoseClientSetNone) {
  server::ServerOptions options = Options();
  options.database.default_deadline_s = 0.5;
  Restart(options);
  const auto lock = LockSite();
  grpc::ClientContext context;
  EXPECT_EQ(RenameSite(context, "Renamed").error_code(), grpc::StatusCode::DEADLINE_EXCEEDED);
  EXPECT_TRUE(AwaitLockWaits("0"));
}

TEST_F(CallsTest, AnswersOfEveryShapeCarryTheRequestId) {
  const auto channel = connection_->channel();
  {
    grpc::ClientContext context;
    context.AddMetadata("x-request-id", "unary-1");
    v1::GetSiteRequest request;
    request.set_name("sites/nowhere");
    v1::GetSiteResponse response;
    EXPECT_EQ(v1::SiteService::NewStub(channel)->GetSite(&context, request, &response).error_code(),
              grpc::StatusCode::NOT_FOUND);
    EXPECT_EQ(RequestIdIn(context), "unary-1");
  }
  {
    grpc::ClientContext context;
    context.AddMetadata("x-request-id", "stream-1");
    v1::ExportGraphRequest request;
    request.set_site("sites/s");
    const auto stub = v1::GraphService::NewStub(channel);
    const auto stream = stub->ExportGraph(&context, request);
    v1::ExportGraphResponse message;
    while (stream->Read(&message)) {
    }
    EXPECT_TRUE(stream->Finish().ok());
    EXPECT_EQ(RequestIdIn(context), "stream-1");
  }
  {
    grpc::ClientContext context;
    context.AddMetadata("x-request-id", "watch-1");
    v1::WatchGlobalPosesRequest request;
    request.set_parent("sites/s");
    const auto stub = v1::GraphService::NewStub(channel);
    const auto stream = stub->WatchGlobalPoses(&context, request);
    v1::WatchGlobalPosesResponse message;
    EXPECT_TRUE(stream->Read(&message));
    EXPECT_EQ(RequestIdIn(context), "watch-1") << "while the watch goes on";
    context.TryCancel();
  }
  {
    grpc::ClientContext context;
    context.AddMetadata("x-request-id", "import-1");
    v1::ImportMapResponse response;
    const auto stub = v1::MapService::NewStub(channel);
    const auto stream = stub->ImportMap(&context, &response);
    stream->WritesDone();
    EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::INVALID_ARGUMENT);
    EXPECT_EQ(RequestIdIn(context), "import-1");
  }
  {
    grpc::ClientContext context;
    context.AddMetadata("x-request-id", "no good id");
    const auto stub = v1::IngestService::NewStub(channel);
    const auto stream = stub->StreamRecords(&context);
    stream->WritesDone();
    EXPECT_TRUE(stream->Finish().ok());
    EXPECT_EQ(RequestIdIn(context).size(), 16U) << "a new one";
  }
}

TEST_F(CallsTest, StreamedPoseReportsAreStoredInTheNameOfTheActor) {
  database_.Sql("CREATE TABLE enfilade.reporters (actor text)");
  database_.Sql(
      "CREATE FUNCTION enfilade.note_reporter() RETURNS trigger LANGUAGE plpgsql AS $$ BEGIN"
      " INSERT INTO enfilade.reporters VALUES (current_setting('enfilade.actor', true)); RETURN NULL; END $$");
  database_.Sql(
      "CREATE TRIGGER note_reporter AFTER INSERT OR UPDATE ON enfilade.robot_poses"
      " FOR EACH ROW EXECUTE FUNCTION enfilade.note_reporter()");
  grpc::ClientContext context;
  context.AddMetadata("enfilade-actor", "robot r");
  const auto stub = v1::IngestService::NewStub(connection_->channel());
  const auto stream = stub->StreamRecords(&context);
  v1::StreamRecordsRequest open;
  open.mutable_open()->set_session(CreateSession(false));
  ASSERT_TRUE(stream->Write(open));
  v1::StreamRecordsResponse opened;
  ASSERT_TRUE(stream->Read(&opened));
  v1::StreamRecordsRequest report;
  report.mutable_pose_report()->set_map("sites/s/maps/m");
  report.mutable_pose_report()->mutable_time()->set_seconds(1'700'000'000);
  report.mutable_pose_report()->mutable_pose_map_robot()->mutable_pose()->set_x(1.0);
  ASSERT_TRUE(stream->Write(report));
  std::string actor;
  for (int i = 0; i < 3000 && actor.empty(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    actor = database_.SqlValue("SELECT actor FROM enfilade.reporters");
  }
  EXPECT_EQ(actor, "robot r");
  stream->WritesDone();
  EXPECT_TRUE(stream->Finish().ok());
}

TEST_F(CallsTest, StreamsCancelledWhileTheyOpenLeaveNothingOpen) {
  const auto streams_open = [this] {
    return Call(&v1::ServerService::Stub::GetServerStatus, v1::GetServerStatusRequest())->streams_open();
  };
  v1::StreamRecordsRequest open;
  open.mutable_open()->set_session(CreateSession(false));
  const auto stub = v1::IngestService::NewStub(connection_->channel());
  for (int i = 0; i < 1500; ++i) {
    grpc::ClientContext context;
    const auto stream = stub->StreamRecords(&context);
    ASSERT_TRUE(stream->Write(open));
    std::this_thread::sleep_for(std::chrono::microseconds(10 * (i % 150)));
    context.TryCancel();
    EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::CANCELLED);
  }
  for (int i = 0; i < 1000 && streams_open() > 0; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_EQ(streams_open(), 0);
}

// The last report of a stream counts although the client is gone when its turn comes.
TEST_F(CallsTest, APoseThatWasReportedIsStoredAfterTheClientHasGone) {
  auto lock = std::make_unique<storage::postgres::Transaction>(LockSite());
  static constexpr storage::postgres::Statement kLockPoses{"locking", "LOCK TABLE enfilade.robot_poses IN SHARE MODE"};
  ASSERT_OK(lock->Execute(kLockPoses, storage::postgres::Params()));
  {
    TestStream stream(*connection_, CreateSession(false));
    stream.Receive();
    v1::StreamRecordsRequest report;
    report.mutable_pose_report()->set_map("sites/s/maps/m");
    report.mutable_pose_report()->mutable_time()->set_seconds(1'700'000'000);
    report.mutable_pose_report()->mutable_pose_map_robot()->mutable_pose()->set_x(3.0);
    ASSERT_TRUE(stream.Send(report));
    ASSERT_TRUE(AwaitLockWaits("1"));
    stream.Cancel();
    EXPECT_CODE(stream.AwaitEnd(), absl::StatusCode::kCancelled);
  }
  lock.reset();
  std::string x;
  for (int i = 0; i < 3000 && x.empty(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    x = database_.SqlValue("SELECT ST_X(point) FROM enfilade.robot_poses");
  }
  EXPECT_EQ(x, "3");
}

TEST_F(CallsTest, AStreamMayBeOpenForLongerThanTheDefaultDeadline) {
  server::ServerOptions options = Options();
  options.database.default_deadline_s = 0.3;
  Restart(options);
  const std::string session = CreateSession(false);
  grpc::ClientContext context;
  const auto stub = v1::IngestService::NewStub(connection_->channel());
  const auto stream = stub->StreamRecords(&context);
  std::this_thread::sleep_for(std::chrono::milliseconds(400));
  v1::StreamRecordsRequest open;
  open.mutable_open()->set_session(session);
  ASSERT_TRUE(stream->Write(open));
  v1::StreamRecordsResponse opened;
  EXPECT_TRUE(stream->Read(&opened));
  EXPECT_TRUE(opened.has_opened());
  stream->WritesDone();
  EXPECT_TRUE(stream->Finish().ok());
}

// An RPC of the protos that has no line in server/rpc/api.cc would be UNIMPLEMENTED.
TEST_F(CallsTest, EveryRpcOfTheApiIsServed) {
  grpc::GenericStub stub(connection_->channel());
  int rpcs = 0;
  for (const auto* file : {v1::GraphService::service_full_name(), v1::IngestService::service_full_name(),
                           v1::LinkPointService::service_full_name(), v1::LocalizationService::service_full_name(),
                           v1::MapAreaService::service_full_name(), v1::MapEditService::service_full_name(),
                           v1::MapService::service_full_name(), v1::PriorMapService::service_full_name(),
                           v1::RasterService::service_full_name(), v1::RobotService::service_full_name(),
                           v1::ServerService::service_full_name(), v1::SessionService::service_full_name(),
                           v1::SiteService::service_full_name(), v1::WatchService::service_full_name()}) {
    const auto* service = google::protobuf::DescriptorPool::generated_pool()->FindServiceByName(file);
    ASSERT_NE(service, nullptr) << file;
    for (int i = 0; i < service->method_count(); ++i, ++rpcs) {
      const std::string method = std::string("/") + file + "/" + service->method(i)->name();
      grpc::ClientContext context;
      context.set_deadline(std::chrono::system_clock::now() + seconds(60));
      grpc::CompletionQueue queue;
      void* tag = nullptr;
      bool ok = false;
      const auto call = stub.PrepareCall(&context, method, &queue);
      call->StartCall(nullptr);
      queue.Next(&tag, &ok);
      const grpc::Slice empty;
      call->WriteLast(grpc::ByteBuffer(&empty, 1), grpc::WriteOptions(), nullptr);
      queue.Next(&tag, &ok);
      grpc::ByteBuffer answer;
      call->Read(&answer, nullptr);
      queue.Next(&tag, &ok);
      grpc::Status status;
      call->Finish(&status, nullptr);
      queue.Next(&tag, &ok);
      EXPECT_NE(status.error_code(), grpc::StatusCode::UNIMPLEMENTED) << method;
      EXPECT_NE(status.error_code(), grpc::StatusCode::DEADLINE_EXCEEDED) << method;
      EXPECT_NE(RequestIdIn(context), "") << method;
    }
  }
  EXPECT_EQ(rpcs, 111) << "a new RPC: its handler, tests and docs/api.md are there?";
}

}  // namespace
}  // namespace enfilade::testing
