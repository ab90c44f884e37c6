// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/api.h"

#include <chrono>
#include <optional>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "enfilade/v1/graph_service.grpc.pb.h"
#include "enfilade/v1/ingest_service.grpc.pb.h"
#include "enfilade/v1/link_point_service.grpc.pb.h"
#include "enfilade/v1/localization_service.grpc.pb.h"
#include "enfilade/v1/map_area_service.grpc.pb.h"
#include "enfilade/v1/map_edit_service.grpc.pb.h"
#include "enfilade/v1/map_service.grpc.pb.h"
#include "enfilade/v1/prior_map_service.grpc.pb.h"
#include "enfilade/v1/raster_service.grpc.pb.h"
#include "enfilade/v1/robot_service.grpc.pb.h"
#include "enfilade/v1/server_service.grpc.pb.h"
#include "enfilade/v1/session_service.grpc.pb.h"
#include "enfilade/v1/site_service.grpc.pb.h"
#include "enfilade/v1/watch_service.grpc.pb.h"
#include "server/rpc/area/handlers.h"
#include "server/rpc/call/arena_messages.h"
#include "server/rpc/edit/handlers.h"
#include "server/rpc/graph/export_graph.h"
#include "server/rpc/graph/get_global_pose.h"
#include "server/rpc/graph/handlers.h"
#include "server/rpc/graph/watch_global_poses.h"
#include "server/rpc/ingest/download_blob.h"
#include "server/rpc/ingest/handlers.h"
#include "server/rpc/ingest/stream_records.h"
#include "server/rpc/link_point/attach_evidence.h"
#include "server/rpc/link_point/handlers.h"
#include "server/rpc/localization/handlers.h"
#include "server/rpc/map/export_map.h"
#include "server/rpc/map/handlers.h"
#include "server/rpc/map/import_map.h"
#include "server/rpc/prior/handlers.h"
#include "server/rpc/prior/import_prior_map.h"
#include "server/rpc/raster/handlers.h"
#include "server/rpc/rearrange/handlers.h"
#include "server/rpc/robot/handlers.h"
#include "server/rpc/rpc_lines.h"
#include "server/rpc/server/handlers.h"
#include "server/rpc/service_api.h"
#include "server/rpc/session/export_trajectory.h"
#include "server/rpc/session/handlers.h"
#include "server/rpc/site/handlers.h"
#include "server/rpc/watch/watch_site.h"
#include "spdlog/spdlog.h"

namespace enfilade::server {
namespace {

class SiteApi final : public ApiOf<v1::SiteService::CallbackService> {
 public:
  using ApiOf::ApiOf;

  ENFILADE_UNARY(CreateSite)
  ENFILADE_UNARY(GetSite)
  ENFILADE_UNARY(ListSites)
  ENFILADE_UNARY(UpdateSite)
  ENFILADE_UNARY(DeleteSite)
  ENFILADE_UNARY(ListAuditEntries)
};

class RobotApi final : public ApiOf<v1::RobotService::CallbackService> {
 public:
  using ApiOf::ApiOf;

  ENFILADE_UNARY(CreateRobot)
  ENFILADE_UNARY(GetRobot)
  ENFILADE_UNARY(ListRobots)
  ENFILADE_UNARY(DeleteRobot)
};

class MapApi final : public ApiOf<v1::MapService::WithRawCallbackMethod_ExportMap<v1::MapService::CallbackService>> {
 public:
  using ApiOf::ApiOf;

  ENFILADE_UNARY_CHANGES_GRAPH(CreateMap)
  ENFILADE_UNARY(GetMap)
  ENFILADE_UNARY(ListMaps)
  ENFILADE_UNARY_CHANGES_GRAPH(UpdateMap)
  ENFILADE_UNARY_CHANGES_GRAPH(DeleteMap)
  ENFILADE_UNARY(GetMapRevision)
  ENFILADE_UNARY(TagMapRevision)
  ENFILADE_UNARY(ListMapRevisions)
  ENFILADE_UNARY(SetMapAlias)
  ENFILADE_UNARY(RollBackMapAlias)
  ENFILADE_UNARY(ListMapAliases)
  ENFILADE_UNARY(DeleteMapAlias)
  ENFILADE_BULK_UNARY(RestoreMapRevision)
  ENFILADE_BULK_UNARY(DiffMapRevisions)
  ENFILADE_RAW_SERVER_STREAM(ExportMap)
  ENFILADE_CLIENT_STREAM(ImportMap)
  ENFILADE_UNARY_CHANGES_GRAPH(MergeMaps, CallLane::kSlow)
  ENFILADE_UNARY_CHANGES_GRAPH(SplitMap, CallLane::kSlow)
  ENFILADE_UNARY_CHANGES_GRAPH(UndoRearrangement, CallLane::kSlow)
  ENFILADE_UNARY(ListRearrangements)
};

class MapAreaApi final : public ApiOf<v1::MapAreaService::CallbackService> {
 public:
  using ApiOf::ApiOf;

  ENFILADE_UNARY(CreateMapArea)
  ENFILADE_UNARY(GetMapArea)
  ENFILADE_UNARY(ListMapAreas)
  ENFILADE_UNARY(UpdateMapArea)
  ENFILADE_UNARY(DeleteMapArea)
  ENFILADE_SLOW_SERVER_STREAM(ExportMapAreas)
};

class LinkPointApi final : public ApiOf<v1::LinkPointService::CallbackService> {
 public:
  LinkPointApi(const Services& services, const CallEnvironment& calls) : ApiOf(services, calls) {
    SetMessageAllocatorFor_FindLinkPoints(&find_messages_);
  }

  ENFILADE_UNARY_CHANGES_GRAPH(CreateLinkPoint)
  ENFILADE_UNARY_CHANGES_GRAPH(AddLinkPointAnchor)
  ENFILADE_UNARY(GetLinkPoint)
  ENFILADE_UNARY(ListLinkPoints)
  ENFILADE_UNARY_CHANGES_GRAPH(UpdateLinkPoint)
  ENFILADE_UNARY_CHANGES_GRAPH(DeleteLinkPoint)
  ENFILADE_UNARY_CHANGES_GRAPH(SuspendLinkPoint)
  ENFILADE_UNARY_CHANGES_GRAPH(ResumeLinkPoint)
  ENFILADE_UNARY_ON_GRAPH_OR_NOW(FindLinkPoints)
  ENFILADE_CLIENT_STREAM(AttachEvidence)

 private:
  ArenaMessages<v1::FindLinkPointsRequest, v1::FindLinkPointsResponse> find_messages_;
};

class SessionApi final : public ApiOf<v1::SessionService::CallbackService> {
 public:
  using ApiOf::ApiOf;

  ENFILADE_UNARY_CHANGES_GRAPH(CreateSession)
  ENFILADE_UNARY(GetSession)
  ENFILADE_UNARY(ListSessions)
  ENFILADE_UNARY(FinishSession)
  ENFILADE_UNARY(DeleteSession)
  ENFILADE_SERVER_STREAM(ExportTrajectory)
  ENFILADE_UNARY(ListClosures)
  ENFILADE_UNARY(SuspendClosure)
  ENFILADE_UNARY(ResumeClosure)
  ENFILADE_UNARY(ListDoorVerdicts)
  ENFILADE_UNARY(GetDoorImages)
};

class GraphApi final : public ApiOf<v1::GraphService::CallbackService> {
 public:
  using ApiOf::ApiOf;

  ENFILADE_UNARY_ON_GRAPH(GetGraph, CallLane::kBulk)
  ENFILADE_UNARY(ListGraphVersions)
  ENFILADE_UNARY(ListPlacedMaps)
  ENFILADE_UNARY_CHANGES_READ_GRAPH(OptimizeGraph, CallLane::kSlow)
  ENFILADE_UNARY_ON_GRAPH(PreviewGraph, CallLane::kSlow)
  ENFILADE_UNARY_CHANGES_GRAPH(ChangeGraph)
  ENFILADE_UNARY_ON_GRAPH(AlignMaps, CallLane::kSlow)
  ENFILADE_UNARY_ON_GRAPH_OR_NOW(GetGlobalPose)
  ENFILADE_WATCH(WatchGlobalPoses)
  ENFILADE_UNARY_ON_GRAPH(TransformPoses)
  ENFILADE_UNARY_ON_GRAPH(FindRoutes, CallLane::kSlow)
  ENFILADE_SERVER_STREAM_ON_GRAPH(ExportGraph)
  ENFILADE_UNARY_CHANGES_READ_GRAPH(SetGeoreference)
  ENFILADE_UNARY_ON_GRAPH(GetGeoreference)
};

class LocalizationApi final : public ApiOf<v1::LocalizationService::CallbackService> {
 public:
  using ApiOf::ApiOf;

  ENFILADE_UNARY_ON_GRAPH(LocalizeRobot, CallLane::kSlow)
};

class IngestApi final : public ApiOf<v1::IngestService::CallbackService> {
 public:
  using ApiOf::ApiOf;

  ENFILADE_BIDI_STREAM(StreamRecords)
  ENFILADE_UNARY(SubmitScan)
  ENFILADE_UNARY(SubmitOdometry)
  ENFILADE_UNARY(SubmitImage)
  ENFILADE_UNARY(SubmitPointCloud)
  ENFILADE_SERVER_STREAM(DownloadBlob)
};

class ServerApi final : public ApiOf<v1::ServerService::CallbackService> {
 public:
  using ApiOf::ApiOf;

  ENFILADE_UNARY(GetServerStatus)
};

class RasterApi final : public ApiOf<v1::RasterService::CallbackService> {
 public:
  using ApiOf::ApiOf;

  ENFILADE_BULK_UNARY(GetRasterManifest)
  ENFILADE_SERVER_STREAM(ReadTiles)
  ENFILADE_BULK_UNARY(ListRasterThumbnails)
};

class PriorMapApi final : public ApiOf<v1::PriorMapService::CallbackService> {
 public:
  using ApiOf::ApiOf;

  ENFILADE_CLIENT_STREAM(ImportPriorMap)
  ENFILADE_UNARY(GetPriorMap)
  ENFILADE_UNARY(ListPriorMaps)
  ENFILADE_UNARY(UpdatePriorMap)
  ENFILADE_UNARY_CHANGES_GRAPH(DeletePriorMap)
  ENFILADE_UNARY_CHANGES_READ_GRAPH(AlignPriorMap, CallLane::kSlow)
  ENFILADE_UNARY_CHANGES_GRAPH(EditPriorMap, CallLane::kSlow)
  ENFILADE_SLOW_UNARY(LocateInPriorMap)
  ENFILADE_UNARY_CHANGES_GRAPH(ActivatePriorMap)
  ENFILADE_UNARY_CHANGES_GRAPH(SuspendPriorMap)
  ENFILADE_UNARY_ON_GRAPH(ListPriorAssociations, CallLane::kSlow)
  ENFILADE_UNARY_ON_GRAPH(ListPredictedLinkPoints)
  ENFILADE_SERVER_STREAM(ExportPriorMap)
};

class MapEditApi final : public ApiOf<v1::MapEditService::CallbackService> {
 public:
  using ApiOf::ApiOf;

  ENFILADE_UNARY(CreateMapDraft)
  ENFILADE_UNARY(GetMapDraft)
  ENFILADE_UNARY(ListMapDrafts)
  ENFILADE_UNARY(DeleteMapDraft)
  ENFILADE_UNARY(AppendMapEdits)
  ENFILADE_UNARY(SetMapEditsActive)
  ENFILADE_BULK_UNARY(ListMapEdits)
  ENFILADE_BULK_UNARY(ReadMapDraftTiles)
  ENFILADE_UNARY(ReportMapDraftPresence)
  ENFILADE_WATCH(WatchMapDraft)
  ENFILADE_SLOW_UNARY(CheckMapDraft)
  ENFILADE_SLOW_UNARY(RebaseMapDraft)
  ENFILADE_SLOW_UNARY(PublishMapDraft)
  ENFILADE_SLOW_UNARY(ListContestedEdits)
  ENFILADE_SLOW_UNARY(SettleContestedEdits)
};

class WatchApi final : public ApiOf<v1::WatchService::CallbackService> {
 public:
  using ApiOf::ApiOf;

  ENFILADE_WATCH(WatchSite)
};

#undef ENFILADE_UNARY
#undef ENFILADE_UNARY_CHANGES_GRAPH
#undef ENFILADE_UNARY_CHANGES_READ_GRAPH
#undef ENFILADE_UNARY_ON_GRAPH
#undef ENFILADE_BULK_UNARY
#undef ENFILADE_SLOW_UNARY
#undef ENFILADE_UNARY_ON_GRAPH_OR_NOW
#undef ENFILADE_SERVER_STREAM
#undef ENFILADE_SLOW_SERVER_STREAM
#undef ENFILADE_SERVER_STREAM_ON_GRAPH
#undef ENFILADE_RAW_SERVER_STREAM
#undef ENFILADE_WATCH
#undef ENFILADE_CLIENT_STREAM
#undef ENFILADE_BIDI_STREAM

CallEnvironment EnvironmentOf(const Services& services) {
  const std::chrono::duration<double> timeout(services.options.database.default_deadline_s);
  return {.executor = services.executor,
          .bulk = &services.bulk,
          .slow = &services.slow,
          .watches = &services.watches,
          .metrics = services.metrics,
          .logger = spdlog::default_logger(),
          .default_timeout = std::chrono::duration_cast<std::chrono::steady_clock::duration>(timeout),
          .is_being_deleted = [&deletions = services.site_deletions](std::string_view site) {
            return deletions.IsBeingDeleted(site);
          }};
}

}  // namespace

struct Api::Impl {
  explicit Impl(const Services& services)
      : calls(EnvironmentOf(services)),
        site(services, calls),
        robot(services, calls),
        map(services, calls),
        map_area(services, calls),
        graph(services, calls),
        link_point(services, calls),
        session(services, calls),
        ingest(services, calls),
        localization(services, calls),
        server(services, calls),
        raster(services, calls),
        map_edit(services, calls),
        prior_map(services, calls),
        watch(services, calls) {}

  const CallEnvironment calls;
  SiteApi site;
  RobotApi robot;
  MapApi map;
  MapAreaApi map_area;
  GraphApi graph;
  LinkPointApi link_point;
  SessionApi session;
  IngestApi ingest;
  LocalizationApi localization;
  ServerApi server;
  RasterApi raster;
  MapEditApi map_edit;
  PriorMapApi prior_map;
  WatchApi watch;
};

Api::Api(const Services& services) : impl_(std::make_unique<Impl>(services)) {}
Api::~Api() = default;

void Api::RegisterWith(grpc::ServerBuilder& builder) {
  builder.RegisterService(&impl_->site);
  builder.RegisterService(&impl_->robot);
  builder.RegisterService(&impl_->map);
  builder.RegisterService(&impl_->map_area);
  builder.RegisterService(&impl_->graph);
  builder.RegisterService(&impl_->link_point);
  builder.RegisterService(&impl_->session);
  builder.RegisterService(&impl_->ingest);
  builder.RegisterService(&impl_->localization);
  builder.RegisterService(&impl_->server);
  builder.RegisterService(&impl_->raster);
  builder.RegisterService(&impl_->map_edit);
  builder.RegisterService(&impl_->prior_map);
  builder.RegisterService(&impl_->watch);
}

}  // namespace enfilade::server
