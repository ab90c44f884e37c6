// SPDX-License-Identifier: Apache-2.0
#include <atomic>
#include <thread>

#include "enfilade/v1/graph_service.grpc.pb.h"
#include "enfilade/v1/localization_service.grpc.pb.h"
#include "enfilade/v1/map_area_service.grpc.pb.h"
#include "enfilade/v1/map_edit_service.grpc.pb.h"
#include "enfilade/v1/prior_map_service.grpc.pb.h"
#include "enfilade/v1/raster_service.grpc.pb.h"
#include "grpc/grpc.h"
#include "tests/rpc/server_test.h"

namespace enfilade::testing {
namespace {

class CallConventionsTest : public ServerTest {};

template <typename Service, typename Request, typename Response>
void ExpectRefusesEmpty(const client::Connection& connection,
                        grpc::Status (Service::*method)(grpc::ClientContext*, const Request&, Response*)) {
  EXPECT_CODE(connection.Call(method, Request()), absl::StatusCode::kInvalidArgument)
      << Request::descriptor()->full_name();
}

TEST_F(CallConventionsTest, AnEmptyMessageIsRefusedByEveryCallAndEndsNothing) {
  using v1::IngestService;
  using v1::LocalizationService;
  using v1::MapEditService;
  using v1::MapService;
  using v1::RobotService;
  using v1::SessionService;
  using v1::SiteService;
  ExpectRefusesEmpty(*connection_, &SiteService::Stub::CreateSite);
  ExpectRefusesEmpty(*connection_, &SiteService::Stub::GetSite);
  ExpectRefusesEmpty(*connection_, &SiteService::Stub::UpdateSite);
  ExpectRefusesEmpty(*connection_, &SiteService::Stub::DeleteSite);
  ExpectRefusesEmpty(*connection_, &RobotService::Stub::CreateRobot);
  ExpectRefusesEmpty(*connection_, &RobotService::Stub::GetRobot);
  ExpectRefusesEmpty(*connection_, &RobotService::Stub::ListRobots);
  ExpectRefusesEmpty(*connection_, &RobotService::Stub::DeleteRobot);
  ExpectRefusesEmpty(*connection_, &MapService::Stub::CreateMap);
  ExpectRefusesEmpty(*connection_, &MapService::Stub::GetMap);
  ExpectRefusesEmpty(*connection_, &MapService::Stub::ListMaps);
  ExpectRefusesEmpty(*connection_, &MapService::Stub::UpdateMap);
  ExpectRefusesEmpty(*connection_, &MapService::Stub::DeleteMap);
  ExpectRefusesEmpty(*connection_, &MapService::Stub::MergeMaps);
  ExpectRefusesEmpty(*connection_, &MapService::Stub::SplitMap);
  ExpectRefusesEmpty(*connection_, &MapService::Stub::UndoRearrangement);
  ExpectRefusesEmpty(*connection_, &MapService::Stub::ListRearrangements);
  ExpectRefusesEmpty(*connection_, &MapService::Stub::GetMapRevision);
  ExpectRefusesEmpty(*connection_, &MapService::Stub::TagMapRevision);
  ExpectRefusesEmpty(*connection_, &MapService::Stub::ListMapRevisions);
  ExpectRefusesEmpty(*connection_, &MapEditService::Stub::CreateMapDraft);
  ExpectRefusesEmpty(*connection_, &MapEditService::Stub::GetMapDraft);
  ExpectRefusesEmpty(*connection_, &MapEditService::Stub::ListMapDrafts);
  ExpectRefusesEmpty(*connection_, &MapEditService::Stub::DeleteMapDraft);
  ExpectRefusesEmpty(*connection_, &MapEditService::Stub::AppendMapEdits);
  ExpectRefusesEmpty(*connection_, &MapEditService::Stub::SetMapEditsActive);
  ExpectRefusesEmpty(*connection_, &MapEditService::Stub::ListMapEdits);
  ExpectRefusesEmpty(*connection_, &MapEditService::Stub::ReadMapDraftTiles);
  ExpectRefusesEmpty(*connection_, &MapEditService::Stub::ReportMapDraftPresence);
  ExpectRefusesEmpty(*connection_, &MapEditService::Stub::CheckMapDraft);
  ExpectRefusesEmpty(*connection_, &MapEditService::Stub::RebaseMapDraft);
  ExpectRefusesEmpty(*connection_, &MapEditService::Stub::PublishMapDraft);
  ExpectRefusesEmpty(*connection_, &MapEditService::Stub::ListContestedEdits);
  ExpectRefusesEmpty(*connection_, &MapEditService::Stub::SettleContestedEdits);
  ExpectRefusesEmpty(*connection_, &MapService::Stub::SetMapAlias);
  ExpectRefusesEmpty(*connection_, &MapService::Stub::RollBackMapAlias);
  ExpectRefusesEmpty(*connection_, &MapService::Stub::ListMapAliases);
  ExpectRefusesEmpty(*connection_, &MapService::Stub::DeleteMapAlias);
  ExpectRefusesEmpty(*connection_, &MapService::Stub::RestoreMapRevision);
  ExpectRefusesEmpty(*connection_, &MapService::Stub::DiffMapRevisions);
  ExpectRefusesEmpty(*connection_, &SessionService::Stub::CreateSession);
  ExpectRefusesEmpty(*connection_, &SessionService::Stub::GetSession);
  ExpectRefusesEmpty(*connection_, &SessionService::Stub::ListSessions);
  ExpectRefusesEmpty(*connection_, &SessionService::Stub::FinishSession);
  ExpectRefusesEmpty(*connection_, &SessionService::Stub::DeleteSession);
  ExpectRefusesEmpty(*connection_, &SessionService::Stub::ListClosures);
  ExpectRefusesEmpty(*connection_, &SessionService::Stub::GetDoorImages);
  ExpectRefusesEmpty(*connection_, &SessionService::Stub::SuspendClosure);
  ExpectRefusesEmpty(*connection_, &SessionService::Stub::ResumeClosure);
  ExpectRefusesEmpty(*connection_, &IngestService::Stub::SubmitScan);
  ExpectRefusesEmpty(*connection_, &IngestService::Stub::SubmitOdometry);
  ExpectRefusesEmpty(*connection_, &IngestService::Stub::SubmitImage);
  ExpectRefusesEmpty(*connection_, &IngestService::Stub::SubmitPointCloud);
  ExpectRefusesEmpty(*connection_, &LocalizationService::Stub::LocalizeRobot);
  ExpectRefusesEmpty(*connection_, &v1::MapAreaService::Stub::CreateMapArea);
  ExpectRefusesEmpty(*connection_, &v1::MapAreaService::Stub::GetMapArea);
  ExpectRefusesEmpty(*connection_, &v1::MapAreaService::Stub::ListMapAreas);
  ExpectRefusesEmpty(*connection_, &v1::MapAreaService::Stub::UpdateMapArea);
  ExpectRefusesEmpty(*connection_, &v1::MapAreaService::Stub::DeleteMapArea);
  ExpectRefusesEmpty(*connection_, &v1::GraphService::Stub::PreviewGraph);
  ExpectRefusesEmpty(*connection_, &v1::GraphService::Stub::ChangeGraph);
  ExpectRefusesEmpty(*connection_, &v1::GraphService::Stub::AlignMaps);
  ExpectRefusesEmpty(*connection_, &v1::PriorMapService::Stub::GetPriorMap);
  ExpectRefusesEmpty(*connection_, &v1::PriorMapService::Stub::ListPriorMaps);
  ExpectRefusesEmpty(*connection_, &v1::PriorMapService::Stub::UpdatePriorMap);
  ExpectRefusesEmpty(*connection_, &v1::PriorMapService::Stub::DeletePriorMap);
  ExpectRefusesEmpty(*connection_, &v1::PriorMapService::Stub::AlignPriorMap);
  ExpectRefusesEmpty(*connection_, &v1::PriorMapService::Stub::EditPriorMap);
  ExpectRefusesEmpty(*connection_, &v1::PriorMapService::Stub::ActivatePriorMap);
  ExpectRefusesEmpty(*connection_, &v1::PriorMapService::Stub::SuspendPriorMap);
  ExpectRefusesEmpty(*connection_, &v1::PriorMapService::Stub::LocateInPriorMap);
  ExpectRefusesEmpty(*connection_, &v1::PriorMapService::Stub::ListPriorAssociations);
  ExpectRefusesEmpty(*connection_, &v1::PriorMapService::Stub::ListPredictedLinkPoints);
  ExpectRefusesEmpty(*connection_, &v1::RasterService::Stub::GetRasterManifest);
  ExpectRefusesEmpty(*connection_, &v1::RasterService::Stub::ListRasterThumbnails);

  const auto first_of = [&](auto reader) {
    typename std::remove_reference_t<decltype(*reader.second)>* stream = reader.second.get();
    decltype(reader.first) message;
    EXPECT_FALSE(stream->Read(&message));
    return client::FromGrpcStatus(stream->Finish());
  };
  const auto maps = MapService::NewStub(connection_->channel());
  const auto sessions = SessionService::NewStub(connection_->channel());
  const auto ingest = IngestService::NewStub(connection_->channel());
  const auto edits = MapEditService::NewStub(connection_->channel());
  const auto areas = v1::MapAreaService::NewStub(connection_->channel());
  grpc::ClientContext contexts[6];
  EXPECT_CODE(first_of(std::pair(v1::ExportMapResponse(), maps->ExportMap(&contexts[0], {}))),
              absl::StatusCode::kInvalidArgument);
  EXPECT_CODE(first_of(std::pair(v1::ExportTrajectoryResponse(), sessions->ExportTrajectory(&contexts[1], {}))),
              absl::StatusCode::kInvalidArgument);
  EXPECT_CODE(first_of(std::pair(v1::DownloadBlobResponse(), ingest->DownloadBlob(&contexts[2], {}))),
              absl::StatusCode::kInvalidArgument);
  EXPECT_CODE(first_of(std::pair(v1::WatchMapDraftResponse(), edits->WatchMapDraft(&contexts[5], {}))),
              absl::StatusCode::kInvalidArgument);
  EXPECT_CODE(first_of(std::pair(v1::ExportMapAreasResponse(), areas->ExportMapAreas(&contexts[4], {}))),
              absl::StatusCode::kInvalidArgument);
  v1::ImportMapResponse imported;
  const auto import = maps->ImportMap(&contexts[3], &imported);
  import->Write(v1::ImportMapRequest());
  import->WritesDone();
  EXPECT_CODE(client::FromGrpcStatus(import->Finish()), absl::StatusCode::kInvalidArgument);

  ASSERT_OK_AND_ASSIGN(const auto status,
                       Call(&v1::ServerService::Stub::GetServerStatus, v1::GetServerStatusRequest()));
  EXPECT_TRUE(status.ready());
  EXPECT_EQ(status.schema_version(), status.expected_schema_version());
}

// An answer that quotes all of it would not fit into the response's metadata.
TEST_F(CallConventionsTest, AnEnormousTextIsRefusedLikeAnyOther) {
  v1::ListAuditEntriesRequest request;
  request.set_parent("sites/s");
  request.set_page_token(std::string(400'000, 'a'));
  EXPECT_CODE(Call(&v1::SiteService::Stub::ListAuditEntries, request), absl::StatusCode::kInvalidArgument);
}

TEST_F(CallConventionsTest, StreamsAreToldToComeAgainWhenTheServerEnds) {
  const std::string session = CreateSession(false);
  TestStream stream(*connection_, session);
  stream.Receive();
  stream.SendBatch(ScanRecords(1, 100));
  ASSERT_TRUE(stream.AwaitAcknowledged(100));
  std::thread shutdown([this] { server_->Shutdown(); });
  EXPECT_CODE(stream.AwaitEnd(), absl::StatusCode::kUnavailable);
  shutdown.join();
}

TEST_F(CallConventionsTest, ASecondServerOnTheSameAddressSaysSo) {
  server::ServerOptions options = Options();
  options.database.url = database_.url();
  options.listen.address = "127.0.0.1:0";
  ASSERT_OK_AND_ASSIGN(const auto first, server::Server::Start(options, slam::SlamOptions()));
  options.listen.address = first->address();
  EXPECT_STATUS(server::Server::Start(options, slam::SlamOptions()), absl::StatusCode::kUnavailable,
                ::testing::HasSubstr(first->address()));
}

TEST_F(CallConventionsTest, ManyClientsComeAndGoWhileOthersList) {
  const std::string session = CreateSession(false);
  std::atomic<int> next{0};
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&] {
      for (int i = next++; i < 80; i = next++) {
        TestStream stream(*connection_, session);
        if (i % 3 == 0) continue;  // gone before the answer
        stream.Receive();
        stream.SendBatch(ScanRecords(1, 20));
        if (i % 3 == 1) {
          EXPECT_TRUE(stream.AwaitAcknowledged(20));
        }
        EXPECT_EQ(GetSession(session).name(), session);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM session_records"), "20");
}

}  // namespace
}  // namespace enfilade::testing
