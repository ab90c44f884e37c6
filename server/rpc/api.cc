// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/api.h"

#include "enfilade/v1/graph_service.grpc.pb.h"
#include "enfilade/v1/ingest_service.grpc.pb.h"
#include "enfilade/v1/link_point_service.grpc.pb.h"
#include "enfilade/v1/map_service.grpc.pb.h"
#include "enfilade/v1/robot_service.grpc.pb.h"
#include "enfilade/v1/server_service.grpc.pb.h"
#include "enfilade/v1/session_service.grpc.pb.h"
#include "enfilade/v1/site_service.grpc.pb.h"
#include "server/rpc/arena_messages.h"
#include "server/rpc/graph/export_graph.h"
#include "server/rpc/graph/get_global_pose.h"
#include "server/rpc/graph/handlers.h"
#include "server/rpc/graph/watch_global_poses.h"
#include "server/rpc/ingest/download_blob.h"
#include "server/rpc/ingest/handlers.h"
#include "server/rpc/ingest/stream_records.h"
#include "server/rpc/link_point/attach_evidence.h"
#include "server/rpc/link_point/handlers.h"
#include "server/rpc/map/export_map.h"
#include "server/rpc/map/handlers.h"
#include "server/rpc/map/import_map.h"
#include "server/rpc/robot/handlers.h"
#include "server/rpc/server/handlers.h"
#include "server/rpc/server_stream.h"
#include "server/rpc/session/export_trajectory.h"
#include "server/rpc/session/handlers.h"
#include "server/rpc/site/handlers.h"
#include "server/rpc/unary.h"

namespace enfilade::server {
namespace {

using Call = grpc::CallbackServerContext;

class SiteApi final : public v1::SiteService::CallbackService {
 public:
  explicit SiteApi(const Services& services) : services_(services) {}

  grpc::ServerUnaryReactor* CreateSite(Call* call, const v1::CreateSiteRequest* request,
                                       v1::CreateSiteResponse* response) override {
    return RunUnary(services_, call, "CreateSite", request, response, server::CreateSite);
  }
  grpc::ServerUnaryReactor* GetSite(Call* call, const v1::GetSiteRequest* request,
                                    v1::GetSiteResponse* response) override {
    return RunUnary(services_, call, "GetSite", request, response, server::GetSite);
  }
  grpc::ServerUnaryReactor* ListSites(Call* call, const v1::ListSitesRequest* request,
                                      v1::ListSitesResponse* response) override {
    return RunUnary(services_, call, "ListSites", request, response, server::ListSites);
  }
  grpc::ServerUnaryReactor* UpdateSite(Call* call, const v1::UpdateSiteRequest* request,
                                       v1::UpdateSiteResponse* response) override {
    return RunUnary(services_, call, "UpdateSite", request, response, server::UpdateSite);
  }
  grpc::ServerUnaryReactor* DeleteSite(Call* call, const v1::DeleteSiteRequest* request,
                                       v1::DeleteSiteResponse* response) override {
    return RunUnary(services_, call, "DeleteSite", request, response, server::DeleteSite);
  }
  grpc::ServerUnaryReactor* ListAuditEntries(Call* call, const v1::ListAuditEntriesRequest* request,
                                             v1::ListAuditEntriesResponse* response) override {
    return RunUnary(services_, call, "ListAuditEntries", request, response, server::ListAuditEntries);
  }

 private:
  const Services& services_;
};

class RobotApi final : public v1::RobotService::CallbackService {
 public:
  explicit RobotApi(const Services& services) : services_(services) {}

  grpc::ServerUnaryReactor* CreateRobot(Call* call, const v1::CreateRobotRequest* request,
                                        v1::CreateRobotResponse* response) override {
    return RunUnary(services_, call, "CreateRobot", request, response, server::CreateRobot);
  }
  grpc::ServerUnaryReactor* GetRobot(Call* call, const v1::GetRobotRequest* request,
                                     v1::GetRobotResponse* response) override {
    return RunUnary(services_, call, "GetRobot", request, response, server::GetRobot);
  }
  grpc::ServerUnaryReactor* ListRobots(Call* call, const v1::ListRobotsRequest* request,
                                       v1::ListRobotsResponse* response) override {
    return RunUnary(services_, call, "ListRobots", request, response, server::ListRobots);
  }
  grpc::ServerUnaryReactor* DeleteRobot(Call* call, const v1::DeleteRobotRequest* request,
                                        v1::DeleteRobotResponse* response) override {
    return RunUnary(services_, call, "DeleteRobot", request, response, server::DeleteRobot);
  }

 private:
  const Services& services_;
};

class MapApi final : public v1::MapService::WithRawCallbackMethod_ExportMap<v1::MapService::CallbackService> {
 public:
  explicit MapApi(const Services& services) : services_(services) {}

  grpc::ServerUnaryReactor* CreateMap(Call* call, const v1::CreateMapRequest* request,
                                      v1::CreateMapResponse* response) override {
    return RunUnary(services_, call, "CreateMap", request, response, server::CreateMap);
  }
  grpc::ServerUnaryReactor* GetMap(Call* call, const v1::GetMapRequest* request,
                                   v1::GetMapResponse* response) override {
    return RunUnary(services_, call, "GetMap", request, response, server::GetMap);
  }
  grpc::ServerUnaryReactor* ListMaps(Call* call, const v1::ListMapsRequest* request,
                                     v1::ListMapsResponse* response) override {
    return RunUnary(services_, call, "ListMaps", request, response, server::ListMaps);
  }
  grpc::ServerUnaryReactor* UpdateMap(Call* call, const v1::UpdateMapRequest* request,
                                      v1::UpdateMapResponse* response) override {
    return RunUnary(services_, call, "UpdateMap", request, response, server::UpdateMap);
  }
  grpc::ServerUnaryReactor* DeleteMap(Call* call, const v1::DeleteMapRequest* request,
                                      v1::DeleteMapResponse* response) override {
    return RunUnary(services_, call, "DeleteMap", request, response, server::DeleteMap);
  }
  grpc::ServerUnaryReactor* GetMapRevision(Call* call, const v1::GetMapRevisionRequest* request,
                                           v1::GetMapRevisionResponse* response) override {
    return RunUnary(services_, call, "GetMapRevision", request, response, server::GetMapRevision);
  }
  grpc::ServerUnaryReactor* ListMapRevisions(Call* call, const v1::ListMapRevisionsRequest* request,
                                             v1::ListMapRevisionsResponse* response) override {
    return RunUnary(services_, call, "ListMapRevisions", request, response, server::ListMapRevisions);
  }
  grpc::ServerWriteReactor<grpc::ByteBuffer>* ExportMap(Call* call, const grpc::ByteBuffer* request) override {
    return RunServerStream(services_, call, "ExportMap", request, server::ExportMap);
  }
  grpc::ServerReadReactor<v1::ImportMapRequest>* ImportMap(Call* call, v1::ImportMapResponse* response) override {
    return server::ImportMap(services_, call, response);
  }

 private:
  const Services& services_;
};

class LinkPointApi final : public v1::LinkPointService::CallbackService {
 public:
  explicit LinkPointApi(const Services& services) : services_(services) {
    SetMessageAllocatorFor_FindLinkPoints(&find_messages_);
  }

  grpc::ServerUnaryReactor* CreateLinkPoint(Call* call, const v1::CreateLinkPointRequest* request,
                                            v1::CreateLinkPointResponse* response) override {
    return RunUnary(services_, call, "CreateLinkPoint", request, response, server::CreateLinkPoint);
  }
  grpc::ServerUnaryReactor* AddLinkPointAnchor(Call* call, const v1::AddLinkPointAnchorRequest* request,
                                               v1::AddLinkPointAnchorResponse* response) override {
    return RunUnary(services_, call, "AddLinkPointAnchor", request, response, server::AddLinkPointAnchor);
  }
  grpc::ServerUnaryReactor* GetLinkPoint(Call* call, const v1::GetLinkPointRequest* request,
                                         v1::GetLinkPointResponse* response) override {
    return RunUnary(services_, call, "GetLinkPoint", request, response, server::GetLinkPoint);
  }
  grpc::ServerUnaryReactor* ListLinkPoints(Call* call, const v1::ListLinkPointsRequest* request,
                                           v1::ListLinkPointsResponse* response) override {
    return RunUnary(services_, call, "ListLinkPoints", request, response, server::ListLinkPoints);
  }
  grpc::ServerUnaryReactor* UpdateLinkPoint(Call* call, const v1::UpdateLinkPointRequest* request,
                                            v1::UpdateLinkPointResponse* response) override {
    return RunUnary(services_, call, "UpdateLinkPoint", request, response, server::UpdateLinkPoint);
  }
  grpc::ServerUnaryReactor* DeleteLinkPoint(Call* call, const v1::DeleteLinkPointRequest* request,
                                            v1::DeleteLinkPointResponse* response) override {
    return RunUnary(services_, call, "DeleteLinkPoint", request, response, server::DeleteLinkPoint);
  }
  grpc::ServerUnaryReactor* SuspendLinkPoint(Call* call, const v1::SuspendLinkPointRequest* request,
                                             v1::SuspendLinkPointResponse* response) override {
    return RunUnary(services_, call, "SuspendLinkPoint", request, response, server::SuspendLinkPoint);
  }
  grpc::ServerUnaryReactor* ResumeLinkPoint(Call* call, const v1::ResumeLinkPointRequest* request,
                                            v1::ResumeLinkPointResponse* response) override {
    return RunUnary(services_, call, "ResumeLinkPoint", request, response, server::ResumeLinkPoint);
  }
  grpc::ServerUnaryReactor* FindLinkPoints(Call* call, const v1::FindLinkPointsRequest* request,
                                           v1::FindLinkPointsResponse* response) override {
    return RunUnary(services_, call, "FindLinkPoints", request, response, server::FindLinkPoints);
  }
  grpc::ServerReadReactor<v1::AttachEvidenceRequest>* AttachEvidence(Call* call,
                                                                     v1::AttachEvidenceResponse* response) override {
    return server::AttachEvidence(services_, call, response);
  }

 private:
  const Services& services_;
  ArenaMessages<v1::FindLinkPointsRequest, v1::FindLinkPointsResponse> find_messages_;
};

class SessionApi final : public v1::SessionService::CallbackService {
 public:
  explicit SessionApi(const Services& services) : services_(services) {}

  grpc::ServerUnaryReactor* CreateSession(Call* call, const v1::CreateSessionRequest* request,
                                          v1::CreateSessionResponse* response) override {
    return RunUnary(services_, call, "CreateSession", request, response, server::CreateSession);
  }
  grpc::ServerUnaryReactor* GetSession(Call* call, const v1::GetSessionRequest* request,
                                       v1::GetSessionResponse* response) override {
    return RunUnary(services_, call, "GetSession", request, response, server::GetSession);
  }
  grpc::ServerUnaryReactor* ListSessions(Call* call, const v1::ListSessionsRequest* request,
                                         v1::ListSessionsResponse* response) override {
    return RunUnary(services_, call, "ListSessions", request, response, server::ListSessions);
  }
  grpc::ServerUnaryReactor* FinishSession(Call* call, const v1::FinishSessionRequest* request,
                                          v1::FinishSessionResponse* response) override {
    return RunUnary(services_, call, "FinishSession", request, response, server::FinishSession);
  }
  grpc::ServerUnaryReactor* DeleteSession(Call* call, const v1::DeleteSessionRequest* request,
                                          v1::DeleteSessionResponse* response) override {
    return RunUnary(services_, call, "DeleteSession", request, response, server::DeleteSession);
  }
  grpc::ServerWriteReactor<v1::ExportTrajectoryResponse>* ExportTrajectory(
      Call* call, const v1::ExportTrajectoryRequest* request) override {
    return RunServerStream(services_, call, "ExportTrajectory", request, server::ExportTrajectory);
  }
  grpc::ServerUnaryReactor* ListClosures(Call* call, const v1::ListClosuresRequest* request,
                                         v1::ListClosuresResponse* response) override {
    return RunUnary(services_, call, "ListClosures", request, response, server::ListClosures);
  }
  grpc::ServerUnaryReactor* SuspendClosure(Call* call, const v1::SuspendClosureRequest* request,
                                           v1::SuspendClosureResponse* response) override {
    return RunUnary(services_, call, "SuspendClosure", request, response, server::SuspendClosure);
  }
  grpc::ServerUnaryReactor* ResumeClosure(Call* call, const v1::ResumeClosureRequest* request,
                                          v1::ResumeClosureResponse* response) override {
    return RunUnary(services_, call, "ResumeClosure", request, response, server::ResumeClosure);
  }
  grpc::ServerUnaryReactor* ListDoorVerdicts(Call* call, const v1::ListDoorVerdictsRequest* request,
                                             v1::ListDoorVerdictsResponse* response) override {
    return RunUnary(services_, call, "ListDoorVerdicts", request, response, server::ListDoorVerdicts);
  }

 private:
  const Services& services_;
};

class GraphApi final : public v1::GraphService::CallbackService {
 public:
  explicit GraphApi(const Services& services) : services_(services) {}

  grpc::ServerUnaryReactor* GetGraph(Call* call, const v1::GetGraphRequest* request,
                                     v1::GetGraphResponse* response) override {
    return RunUnary(services_, call, "GetGraph", request, response, server::GetGraph);
  }
  grpc::ServerUnaryReactor* ListGraphVersions(Call* call, const v1::ListGraphVersionsRequest* request,
                                              v1::ListGraphVersionsResponse* response) override {
    return RunUnary(services_, call, "ListGraphVersions", request, response, server::ListGraphVersions);
  }
  grpc::ServerUnaryReactor* OptimizeGraph(Call* call, const v1::OptimizeGraphRequest* request,
                                          v1::OptimizeGraphResponse* response) override {
    return RunUnary(services_, call, "OptimizeGraph", request, response, server::OptimizeGraph);
  }
  grpc::ServerUnaryReactor* GetGlobalPose(Call* call, const v1::GetGlobalPoseRequest* request,
                                          v1::GetGlobalPoseResponse* response) override {
    return RunUnary(services_, call, "GetGlobalPose", request, response, server::GetGlobalPose,
                    server::TryGetGlobalPose);
  }
  grpc::ServerWriteReactor<v1::WatchGlobalPosesResponse>* WatchGlobalPoses(
      Call* call, const v1::WatchGlobalPosesRequest* request) override {
    return server::WatchGlobalPoses(services_, call, request);
  }
  grpc::ServerUnaryReactor* TransformPoses(Call* call, const v1::TransformPosesRequest* request,
                                           v1::TransformPosesResponse* response) override {
    return RunUnary(services_, call, "TransformPoses", request, response, server::TransformPoses);
  }
  grpc::ServerUnaryReactor* FindRoutes(Call* call, const v1::FindRoutesRequest* request,
                                       v1::FindRoutesResponse* response) override {
    return RunUnary(services_, call, "FindRoutes", request, response, server::FindRoutes);
  }
  grpc::ServerWriteReactor<v1::ExportGraphResponse>* ExportGraph(Call* call,
                                                                 const v1::ExportGraphRequest* request) override {
    return RunServerStream(services_, call, "ExportGraph", request, server::ExportGraph);
  }
  grpc::ServerUnaryReactor* SetGeoreference(Call* call, const v1::SetGeoreferenceRequest* request,
                                            v1::SetGeoreferenceResponse* response) override {
    return RunUnary(services_, call, "SetGeoreference", request, response, server::SetGeoreference);
  }
  grpc::ServerUnaryReactor* GetGeoreference(Call* call, const v1::GetGeoreferenceRequest* request,
                                            v1::GetGeoreferenceResponse* response) override {
    return RunUnary(services_, call, "GetGeoreference", request, response, server::GetGeoreference);
  }

 private:
  const Services& services_;
};

class IngestApi final : public v1::IngestService::CallbackService {
 public:
  explicit IngestApi(const Services& services) : services_(services) {}

  grpc::ServerBidiReactor<v1::StreamRecordsRequest, v1::StreamRecordsResponse>* StreamRecords(Call*) override {
    return server::StreamRecords(services_);
  }
  grpc::ServerUnaryReactor* SubmitScan(Call* call, const v1::SubmitScanRequest* request,
                                       v1::SubmitScanResponse* response) override {
    return RunUnary(services_, call, "SubmitScan", request, response, server::SubmitScan);
  }
  grpc::ServerUnaryReactor* SubmitOdometry(Call* call, const v1::SubmitOdometryRequest* request,
                                           v1::SubmitOdometryResponse* response) override {
    return RunUnary(services_, call, "SubmitOdometry", request, response, server::SubmitOdometry);
  }
  grpc::ServerUnaryReactor* SubmitImage(Call* call, const v1::SubmitImageRequest* request,
                                        v1::SubmitImageResponse* response) override {
    return RunUnary(services_, call, "SubmitImage", request, response, server::SubmitImage);
  }
  grpc::ServerUnaryReactor* SubmitPointCloud(Call* call, const v1::SubmitPointCloudRequest* request,
                                             v1::SubmitPointCloudResponse* response) override {
    return RunUnary(services_, call, "SubmitPointCloud", request, response, server::SubmitPointCloud);
  }
  grpc::ServerWriteReactor<v1::DownloadBlobResponse>* DownloadBlob(Call* call,
                                                                   const v1::DownloadBlobRequest* request) override {
    return RunServerStream(services_, call, "DownloadBlob", request, server::DownloadBlob);
  }

 private:
  const Services& services_;
};

class ServerApi final : public v1::ServerService::CallbackService {
 public:
  explicit ServerApi(const Services& services) : services_(services) {}

  grpc::ServerUnaryReactor* GetServerStatus(Call* call, const v1::GetServerStatusRequest* request,
                                            v1::GetServerStatusResponse* response) override {
    return RunUnary(services_, call, "GetServerStatus", request, response, server::GetServerStatus);
  }

 private:
  const Services& services_;
};

}  // namespace

struct Api::Impl {
  explicit Impl(const Services& services)
      : site(services),
        robot(services),
        map(services),
        graph(services),
        link_point(services),
        session(services),
        ingest(services),
        server(services) {}

  SiteApi site;
  RobotApi robot;
  MapApi map;
  GraphApi graph;
  LinkPointApi link_point;
  SessionApi session;
  IngestApi ingest;
  ServerApi server;
};

Api::Api(const Services& services) : impl_(std::make_unique<Impl>(services)) {}
Api::~Api() = default;

void Api::RegisterWith(grpc::ServerBuilder& builder) {
  builder.RegisterService(&impl_->site);
  builder.RegisterService(&impl_->robot);
  builder.RegisterService(&impl_->map);
  builder.RegisterService(&impl_->graph);
  builder.RegisterService(&impl_->link_point);
  builder.RegisterService(&impl_->session);
  builder.RegisterService(&impl_->ingest);
  builder.RegisterService(&impl_->server);
}

}  // namespace enfilade::server
