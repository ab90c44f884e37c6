// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.h"
#include "core/base/sha256.h"
#include "enfilade/v1/graph_service.grpc.pb.h"
#include "enfilade/v1/ingest_service.grpc.pb.h"
#include "enfilade/v1/link_point_service.grpc.pb.h"
#include "enfilade/v1/localization_service.grpc.pb.h"
#include "enfilade/v1/map_area_service.grpc.pb.h"
#include "enfilade/v1/map_service.grpc.pb.h"
#include "enfilade/v1/prior_map_service.grpc.pb.h"
#include "enfilade/v1/server_service.grpc.pb.h"
#include "enfilade/v1/session_service.grpc.pb.h"
#include "enfilade/v1/site_service.grpc.pb.h"
#include "grpcpp/security/server_credentials.h"
#include "grpcpp/server.h"
#include "grpcpp/server_builder.h"

namespace enfilade::testing {

// What a call brought besides its request.
struct CallFacts {
  std::string actor;                      // the metadata enfilade-actor
  std::optional<double> seconds_to_live;  // until the deadline; unset without one
};

// What a call answers with. A call keeps the function that it began with, so that a test may set another one while a
// call that its client has given up still runs.
template <typename Function>
class Script {
 public:
  Script& operator=(Function function) {
    const MutexLock lock(mutex_);
    function_ = std::move(function);
    return *this;
  }
  Function Get() const {
    const MutexLock lock(mutex_);
    return function_;
  }

 private:
  mutable Mutex mutex_;
  Function function_ ABSL_GUARDED_BY(mutex_);
};

// A server over real gRPC on a socket, whose answers a test writes as functions: server.maps.list_maps = [](request,
// response) { ... return grpc::Status::OK; }. A call without a function is UNIMPLEMENTED.
class ScriptedServer {
  template <typename Request, typename Response>
  using Unary = std::function<grpc::Status(const Request&, Response&)>;
  template <typename Request, typename Response>
  using Download = std::function<grpc::Status(const Request&, grpc::ServerWriter<Response>&)>;
  template <typename Request, typename Response>
  using Upload = std::function<grpc::Status(grpc::ServerReader<Request>&, Response&)>;

 public:
#define ENFILADE_SCRIPTED(shape, Name, member)                                                    \
  Script<shape<v1::Name##Request, v1::Name##Response>> member;                                    \
  grpc::Status Name(grpc::ServerContext* context, ENFILADE_##shape##_PARAMETERS(Name)) override { \
    owner.Note(*context);                                                                         \
    const auto script = member.Get();                                                             \
    if (!script) return {grpc::StatusCode::UNIMPLEMENTED, #Name};                                 \
    return script(ENFILADE_##shape##_ARGUMENTS);                                                  \
  }
#define ENFILADE_Unary_PARAMETERS(Name) const v1::Name##Request *request, v1::Name##Response *response
#define ENFILADE_Unary_ARGUMENTS *request, *response
#define ENFILADE_Download_PARAMETERS(Name) \
  const v1::Name##Request *request, grpc::ServerWriter<v1::Name##Response>*writer
#define ENFILADE_Download_ARGUMENTS *request, *writer
#define ENFILADE_Upload_PARAMETERS(Name) grpc::ServerReader<v1::Name##Request>*reader, v1::Name##Response *response
#define ENFILADE_Upload_ARGUMENTS *reader, *response

  struct Maps final : v1::MapService::Service {
    explicit Maps(ScriptedServer& server) : owner(server) {}
    ScriptedServer& owner;
    ENFILADE_SCRIPTED(Unary, ListMaps, list_maps)
    ENFILADE_SCRIPTED(Unary, GetMap, get_map)
    ENFILADE_SCRIPTED(Unary, CreateMap, create_map)
    ENFILADE_SCRIPTED(Unary, UpdateMap, update_map)
    ENFILADE_SCRIPTED(Unary, DeleteMap, delete_map)
    ENFILADE_SCRIPTED(Unary, ListMapRevisions, list_revisions)
    ENFILADE_SCRIPTED(Unary, GetMapRevision, get_revision)
    ENFILADE_SCRIPTED(Unary, SetMapAlias, set_alias)
    ENFILADE_SCRIPTED(Unary, RollBackMapAlias, roll_back_alias)
    ENFILADE_SCRIPTED(Unary, ListMapAliases, list_aliases)
    ENFILADE_SCRIPTED(Unary, DeleteMapAlias, delete_alias)
    ENFILADE_SCRIPTED(Unary, RestoreMapRevision, restore_revision)
    ENFILADE_SCRIPTED(Unary, DiffMapRevisions, diff_revisions)
    ENFILADE_SCRIPTED(Download, ExportMap, export_map)
    ENFILADE_SCRIPTED(Upload, ImportMap, import_map)
    ENFILADE_SCRIPTED(Unary, MergeMaps, merge_maps)
    ENFILADE_SCRIPTED(Unary, SplitMap, split_map)
    ENFILADE_SCRIPTED(Unary, UndoRearrangement, undo_rearrangement)
    ENFILADE_SCRIPTED(Unary, ListRearrangements, list_rearrangements)
  };
  struct LinkPoints final : v1::LinkPointService::Service {
    explicit LinkPoints(ScriptedServer& server) : owner(server) {}
    ScriptedServer& owner;
    ENFILADE_SCRIPTED(Unary, CreateLinkPoint, create)
    ENFILADE_SCRIPTED(Unary, AddLinkPointAnchor, add_anchor)
    ENFILADE_SCRIPTED(Unary, GetLinkPoint, get)
    ENFILADE_SCRIPTED(Unary, ListLinkPoints, list)
    ENFILADE_SCRIPTED(Unary, FindLinkPoints, find)
    ENFILADE_SCRIPTED(Unary, UpdateLinkPoint, update)
    ENFILADE_SCRIPTED(Unary, DeleteLinkPoint, remove)
    ENFILADE_SCRIPTED(Unary, SuspendLinkPoint, suspend)
    ENFILADE_SCRIPTED(Unary, ResumeLinkPoint, resume)
    ENFILADE_SCRIPTED(Upload, AttachEvidence, attach_evidence)
  };
  struct Graph final : v1::GraphService::Service {
    explicit Graph(ScriptedServer& server) : owner(server) {}
    ScriptedServer& owner;
    ENFILADE_SCRIPTED(Unary, GetGraph, get_graph)
    ENFILADE_SCRIPTED(Unary, ListGraphVersions, list_versions)
    ENFILADE_SCRIPTED(Unary, ListPlacedMaps, list_placed_maps)
    ENFILADE_SCRIPTED(Unary, OptimizeGraph, optimize)
    ENFILADE_SCRIPTED(Unary, PreviewGraph, preview)
    ENFILADE_SCRIPTED(Unary, ChangeGraph, change)
    ENFILADE_SCRIPTED(Unary, AlignMaps, align)
    ENFILADE_SCRIPTED(Unary, GetGlobalPose, get_global_pose)
    ENFILADE_SCRIPTED(Unary, FindRoutes, find_routes)
    ENFILADE_SCRIPTED(Download, ExportGraph, export_graph)
    ENFILADE_SCRIPTED(Download, WatchGlobalPoses, watch_global_poses)
  };
  struct Sessions final : v1::SessionService::Service {
    explicit Sessions(ScriptedServer& server) : owner(server) {}
    ScriptedServer& owner;
    ENFILADE_SCRIPTED(Unary, ListSessions, list)
    ENFILADE_SCRIPTED(Unary, GetSession, get)
    ENFILADE_SCRIPTED(Unary, ListClosures, list_closures)
    ENFILADE_SCRIPTED(Unary, SuspendClosure, suspend_closure)
    ENFILADE_SCRIPTED(Unary, ResumeClosure, resume_closure)
    ENFILADE_SCRIPTED(Unary, ListDoorVerdicts, list_door_verdicts)
    ENFILADE_SCRIPTED(Download, ExportTrajectory, export_trajectory)
  };
  struct Sites final : v1::SiteService::Service {
    explicit Sites(ScriptedServer& server) : owner(server) {}
    ScriptedServer& owner;
    ENFILADE_SCRIPTED(Unary, CreateSite, create)
    ENFILADE_SCRIPTED(Unary, UpdateSite, update)
    ENFILADE_SCRIPTED(Unary, ListSites, list)
    ENFILADE_SCRIPTED(Unary, ListAuditEntries, list_audit_entries)
  };
  struct Status final : v1::ServerService::Service {
    explicit Status(ScriptedServer& server) : owner(server) {}
    ScriptedServer& owner;
    ENFILADE_SCRIPTED(Unary, GetServerStatus, get)
  };
  struct Localization final : v1::LocalizationService::Service {
    explicit Localization(ScriptedServer& server) : owner(server) {}
    ScriptedServer& owner;
    ENFILADE_SCRIPTED(Unary, LocalizeRobot, localize_robot)
  };
  struct PriorMaps final : v1::PriorMapService::Service {
    explicit PriorMaps(ScriptedServer& server) : owner(server) {}
    ScriptedServer& owner;
    ENFILADE_SCRIPTED(Upload, ImportPriorMap, import_file)
    ENFILADE_SCRIPTED(Unary, GetPriorMap, get)
    ENFILADE_SCRIPTED(Unary, ListPriorMaps, list)
    ENFILADE_SCRIPTED(Unary, UpdatePriorMap, update)
    ENFILADE_SCRIPTED(Unary, DeletePriorMap, remove)
    ENFILADE_SCRIPTED(Unary, AlignPriorMap, align)
    ENFILADE_SCRIPTED(Unary, EditPriorMap, edit)
    ENFILADE_SCRIPTED(Unary, LocateInPriorMap, locate)
    ENFILADE_SCRIPTED(Unary, ActivatePriorMap, activate)
    ENFILADE_SCRIPTED(Unary, SuspendPriorMap, suspend)
    ENFILADE_SCRIPTED(Download, ExportPriorMap, export_files)
  };
  struct MapAreas final : v1::MapAreaService::Service {
    explicit MapAreas(ScriptedServer& server) : owner(server) {}
    ScriptedServer& owner;
    ENFILADE_SCRIPTED(Unary, CreateMapArea, create)
    ENFILADE_SCRIPTED(Unary, GetMapArea, get)
    ENFILADE_SCRIPTED(Unary, ListMapAreas, list)
    ENFILADE_SCRIPTED(Unary, UpdateMapArea, update)
    ENFILADE_SCRIPTED(Unary, DeleteMapArea, remove)
    ENFILADE_SCRIPTED(Download, ExportMapAreas, export_files)
  };
  struct Ingest final : v1::IngestService::Service {
    explicit Ingest(ScriptedServer& server) : owner(server) {}
    ScriptedServer& owner;
    ENFILADE_SCRIPTED(Download, DownloadBlob, download_blob)
  };
#undef ENFILADE_SCRIPTED

  // `socket`: the path of a Unix socket.
  explicit ScriptedServer(const std::string& socket) : address_("unix:" + socket) { Start(); }
  ~ScriptedServer() { Stop(); }

  const std::string& address() const { return address_; }

  void Start() {
    grpc::ServerBuilder builder;
    builder.AddListeningPort(address_, grpc::InsecureServerCredentials());
    for (grpc::Service* service : std::vector<grpc::Service*>{&maps, &link_points, &graph, &sessions, &sites, &status,
                                                              &ingest, &localization, &prior_maps, &map_areas}) {
      builder.RegisterService(service);
    }
    server_ = builder.BuildAndStart();
    if (!server_) throw std::runtime_error("cannot listen at " + address_);
  }
  void Stop() {
    if (!server_) return;
    server_->Shutdown(std::chrono::system_clock::now());
    server_->Wait();
    server_.reset();
  }

  // Of the calls so far, in the order in which they came.
  std::vector<CallFacts> calls() {
    MutexLock lock(mutex_);
    return calls_;
  }

  Maps maps{*this};
  LinkPoints link_points{*this};
  Graph graph{*this};
  Sessions sessions{*this};
  Sites sites{*this};
  Status status{*this};
  Ingest ingest{*this};
  Localization localization{*this};
  PriorMaps prior_maps{*this};
  MapAreas map_areas{*this};

 private:
  void Note(const grpc::ServerContext& context) {
    CallFacts facts;
    const auto actor = context.client_metadata().find("enfilade-actor");
    if (actor != context.client_metadata().end()) facts.actor = {actor->second.data(), actor->second.size()};
    const auto now = std::chrono::system_clock::now();
    if (context.deadline() < now + std::chrono::hours(1000)) {
      facts.seconds_to_live = std::chrono::duration<double>(context.deadline() - now).count();
    }
    MutexLock lock(mutex_);
    calls_.push_back(facts);
  }

  const std::string address_;
  std::unique_ptr<grpc::Server> server_;
  Mutex mutex_;
  std::vector<CallFacts> calls_ ABSL_GUARDED_BY(mutex_);
};

// Adds a file to a manifest, such as v1::ExportMapManifest.
template <typename Manifest>
void AddToManifest(const std::string& name, const std::string& bytes, Manifest& manifest) {
  v1::FileEntry& file = *manifest.add_files();
  file.set_name(name);
  file.set_size_bytes(static_cast<std::int64_t>(bytes.size()));
  file.set_sha256(Sha256(bytes));
}

// A chunk of a download, such as v1::ExportMapResponse.
template <typename Response>
Response ChunkOf(int file, std::int64_t offset, const std::string& data) {
  Response response;
  response.mutable_chunk()->set_file(file);
  response.mutable_chunk()->set_offset(offset);
  response.mutable_chunk()->set_data(data);
  return response;
}

}  // namespace enfilade::testing
