// SPDX-License-Identifier: Apache-2.0
#include "server/server.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <thread>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "grpcpp/ext/proto_server_reflection_plugin.h"
#include "grpcpp/grpcpp.h"
#include "grpcpp/health_check_service_interface.h"
#include "server/app/closure/door_closures.h"
#include "server/app/closure/plan_door_joiner.h"
#include "server/app/priors/plan_realigner.h"
#include "server/app/rearrange/rearranger.h"
#include "server/app/runtime/maintenance_jobs.h"
#include "server/app/services.h"
#include "server/app/survey/site_surveyor.h"
#include "server/credentials.h"
#include "server/rpc/api.h"
#include "spdlog/spdlog.h"
#include "storage/postgres/driver/pool.h"
#include "storage/postgres/graph/graph_store.h"
#include "storage/postgres/graph/link_point_store.h"
#include "storage/postgres/graph/robot_pose_store.h"
#include "storage/postgres/graph/site_lease_store.h"
#include "storage/postgres/maps/blob_store.h"
#include "storage/postgres/maps/map_store.h"
#include "storage/postgres/maps/revision_store.h"
#include "storage/postgres/rearrange/rearrangement_store.h"
#include "storage/postgres/rearrange/survey_store.h"
#include "storage/postgres/sessions/mapping_store.h"
#include "storage/postgres/sessions/record_store.h"
#include "storage/postgres/sessions/session_store.h"

namespace enfilade::server {
namespace {

constexpr std::size_t kMaxQueuedCalls = 1000;
constexpr int kBulkThreads = 3;
constexpr int kSlowThreads = 2;
constexpr std::size_t kMaxQueuedSlowCalls = 200;
constexpr int kWatchThreads = 2;
constexpr auto kReadinessTimeout = std::chrono::seconds(3);
constexpr double kLongestRealignPoll = 60.0;  // s
constexpr std::chrono::seconds kPlanDoorsPoll{1};

// Slow calls together leave half of the processors to mapping, where there are four or more.
int ThreadsOfSlowCall() {
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()) / (2 * kSlowThreads));
}

std::chrono::seconds WholeSeconds(double seconds) { return std::chrono::seconds(static_cast<std::int64_t>(seconds)); }

storage::postgres::PoolOptions PoolOptionsOf(const ServerOptions::Database& options) {
  storage::postgres::PoolOptions pool;
  pool.url = options.url;
  pool.max_connections = options.max_connections;
  pool.application_name = "enfilade-server";
  return pool;
}

std::chrono::milliseconds StepTimeout(const ServerOptions& options) {
  return std::chrono::milliseconds(std::llround(options.database.default_deadline_s * 1000.0));
}

UploadSpace::Options UploadSpaceOptionsOf(const ServerOptions& options) {
  const std::string& directory = options.transfers.upload_directory;
  return {.directory = directory.empty() ? std::filesystem::temp_directory_path().string() : directory,
          .memory_bytes = options.transfers.upload_memory_bytes,
          .disk_bytes = options.transfers.upload_disk_bytes};
}

PoseLooks::Options PoseLooksOptionsOf(const ServerOptions& options) {
  return {.max_per_site = options.watches.max_per_site,
          .max_in_all = options.watches.max_in_all,
          .timeout = StepTimeout(options)};
}

}  // namespace

// Members are destroyed in reverse order: each is declared after what it uses.
class Server::Impl {
 public:
  Impl(const ServerOptions& given, const slam::SlamProfiles& slam, std::unique_ptr<storage::postgres::Pool> given_pool,
       std::unique_ptr<Metrics> given_metrics)
      : options(given),
        slam_profiles(slam),
        pool(std::move(given_pool)),
        metrics(std::move(given_metrics)),
        executor(options.listen.workers, kMaxQueuedCalls),
        mapping(options.mapping, slam, {mappings, records, sessions, blobs, revisions, robot_poses, maps}, *metrics,
                [this] {
                  doors_wake.Wake();
                  survey_wake.Wake();
                }),
        ingest(options.ingest, records, blobs, *metrics,
               [this](const SiteId& site, const SessionId& session) { mapping.Wake(site, session); }),
        pose_reports(robot_poses, {.timeout = StepTimeout(options)}) {}

  absl::Status Start() {
    ENFILADE_ASSIGN_OR_RETURN(exports, MapExports::Create(options.transfers, maps, {blobs, revisions}));
    grpc::EnableDefaultHealthCheckService(true);
    grpc::reflection::InitProtoReflectionServerBuilderPlugin();
    // Checks the database once before the first call can come.
    readiness = std::make_unique<Readiness>(
        [this] { return storage::CheckSchema(storage::CallContext::WithTimeout(kReadinessTimeout), *pool); },
        [this](const Readiness::State& state) { SetReady(state); });
    site_deletions = std::make_unique<SiteDeletions>(
        SiteDeletions::Options{.is_ready = [this] { return readiness->state().ready; },
                               .forget = [this](const SiteId& site) { graphs.Forget(site); }},
        sites, site_deletion, *metrics);
    services = std::make_unique<Services>(Services{options,
                                                   std::chrono::steady_clock::now(),
                                                   executor,
                                                   bulk,
                                                   slow,
                                                   watches,
                                                   *metrics,
                                                   *readiness,
                                                   sites,
                                                   robots,
                                                   maps,
                                                   map_areas,
                                                   revisions,
                                                   map_aliases,
                                                   pyramids,
                                                   map_edit_store,
                                                   prior_maps,
                                                   sessions,
                                                   records,
                                                   blobs,
                                                   mappings,
                                                   closures,
                                                   link_points,
                                                   graph_store,
                                                   robot_poses,
                                                   activity,
                                                   audit,
                                                   door_verdicts,
                                                   rearrangement_store,
                                                   plan_joins,
                                                   uploads,
                                                   ingest,
                                                   pose_reports,
                                                   mapping,
                                                   doors_wake,
                                                   *exports,
                                                   map_edits,
                                                   draft_presences,
                                                   raster_pyramids,
                                                   prior_alignment,
                                                   plan_localization,
                                                   graphs,
                                                   graph_waits,
                                                   pose_looks,
                                                   site_looks,
                                                   graph_editor,
                                                   graph_optimizer,
                                                   map_entries,
                                                   rearrangements,
                                                   localization,
                                                   *site_deletions});
    api = std::make_unique<Api>(*services);
    if (options.survey.share > 0.0) {
      survey::SurveyOptions survey_options;
      survey_options.map_name = options.closure.map_name;
      surveyor = std::make_unique<SiteSurveyor>(
          survey_options,
          SurveyScheduleOptions{options.survey.growth, std::chrono::duration<double>(options.survey.interval_s)},
          SurveyLoad{options.survey.share, options.survey.cache_bytes},
          SurveyMappingOptions{{.window_s = options.mapping.pairing_window_s}, slam_profiles},
          SiteSurveyor::Stores{{sessions, records, mappings, maps, door_verdicts, plan_joins}, surveys, site_leases},
          graphs, rearranger, survey_wake);
    }
    ENFILADE_RETURN_IF_ERROR(Listen());
    grpc->GetHealthCheckService()->SetServingStatus(readiness->state().ready);
    maintenance_loop = std::make_unique<MaintenanceLoop>(
        MaintenanceLoop::Options{.interval = std::chrono::duration<double>(options.retention.interval_s),
                                 .is_ready = [this] { return readiness->state().ready; },
                                 .on_tick = [this] { UpdateMetrics(); }},
        MaintenanceJobs({maintenance, sessions},
                        {.undo_kept = WholeSeconds(options.retention.undo_s),
                         .idle = WholeSeconds(options.retention.idle_session_s),
                         .deleted_session = WholeSeconds(options.retention.deleted_session_s),
                         .unused_blob = WholeSeconds(options.retention.unused_blob_s)},
                        *metrics));
    if (options.prior_maps.realign_s > 0.0) {
      realigner =
          std::make_unique<PlanRealigner>(prior_maps, prior_alignment, WholeSeconds(options.prior_maps.realign_s));
      realign_loop = std::make_unique<MaintenanceLoop>(
          MaintenanceLoop::Options{
              .interval = std::chrono::duration<double>(std::min(options.prior_maps.realign_s, kLongestRealignPoll)),
              .is_ready = [this] { return readiness->state().ready; },
              .on_tick = [] {}},
          std::vector<MaintenanceJob>{realigner->Job()});
    }
    plan_doors_loop = std::make_unique<MaintenanceLoop>(
        MaintenanceLoop::Options{
            .interval = kPlanDoorsPoll, .is_ready = [this] { return readiness->state().ready; }, .on_tick = [] {}},
        std::vector<MaintenanceJob>{plan_door_joiner.Job()});
    return absl::OkStatus();
  }

  void UpdateMetrics() {
    const storage::postgres::Pool::Stats stats = pool->stats();
    metrics->SetDatabaseConnections(stats.open, stats.busy, stats.waiting);
    metrics->SetWatchers(pose_looks.watchers());
  }

  absl::Status Listen() {
    for (const std::string& warning : options.Warnings()) spdlog::warn("{}", warning);
    grpc::ServerBuilder builder;
    int port = 0;
    ENFILADE_ASSIGN_OR_RETURN(credentials, MakeListenCredentials(options.listen, *metrics));
    builder.AddListeningPort(options.listen.address, credentials.credentials, &port);
    builder.SetMaxReceiveMessageSize(static_cast<int>(options.listen.max_message_bytes));
    // A second server on the same port must fail instead of receiving half of the calls.
    builder.AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);
    // Detects robots that vanish without closing their connection, and allows their keep-alive pings.
    builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, 30'000);
    builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 10'000);
    builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
    builder.AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, 5'000);
    api->RegisterWith(builder);
    grpc = builder.BuildAndStart();
    if (!grpc || (port == 0 && options.listen.address.rfind("unix:", 0) != 0)) {
      return Unavailable("cannot listen at {}: is the port in use? Choose another listen.address",
                         options.listen.address);
    }
    address = options.listen.address;
    if (port > 1) address = address.substr(0, address.rfind(':') + 1) + std::to_string(port);
    return absl::OkStatus();
  }

  void SetReady(const Readiness::State& state) {
    metrics->SetReady(state.ready);
    if (state.ready) {
      spdlog::info("ready: schema {}", state.schema.deployed);
    } else {
      spdlog::warn("not ready: {}{}", state.reason, state.detail.empty() ? "" : " (" + state.detail + ")");
    }
    if (grpc) grpc->GetHealthCheckService()->SetServingStatus(state.ready);
  }

  void Shutdown() {
    if (!grpc) return;
    const auto deadline =
        std::chrono::system_clock::now() + std::chrono::milliseconds(std::llround(options.listen.grace_s * 1000.0));
    spdlog::info("shutting down: {} streams, {} sessions being mapped", metrics->streams_open(),
                 metrics->sessions_mapping());
    if (readiness) readiness->Drain();
    mapping.Stop();
    ingest.Drain();
    door_closures.Stop();
    if (surveyor) surveyor->Stop();
    graph_optimizer.Stop();
    if (site_deletions) site_deletions->Stop();
    graphs.Stop();
    grpc->Shutdown(deadline);
    grpc->Wait();
    grpc.reset();
    pose_reports.Stop();  // its answers use the executor
    executor.Stop();      // an answered call may still be returning from its handler
    bulk.Stop();
    slow.Stop();
    pose_looks.Stop();
    site_looks.Stop();
    watches.Stop();
  }

  const ServerOptions options;
  const slam::SlamProfiles slam_profiles;
  const std::unique_ptr<storage::postgres::Pool> pool;
  const std::unique_ptr<Metrics> metrics;
  ListenCredentials credentials;
  const storage::SiteStore sites{*pool};
  const storage::RobotStore robots{*pool};
  const storage::postgres::MapStore maps{*pool};
  const storage::MapAreaStore map_areas{*pool};
  const storage::postgres::RevisionStore revisions{*pool};
  const storage::MapAliasStore map_aliases{*pool};
  const storage::PyramidStore pyramids{*pool};
  const storage::MapEditStore map_edit_store{*pool};
  const storage::PriorMapStore prior_maps{*pool};
  const storage::postgres::SessionStore sessions{*pool};
  const storage::postgres::RecordStore records{*pool};
  const storage::postgres::BlobStore blobs{*pool};
  const storage::postgres::MappingStore mappings{*pool};
  const storage::LoopClosureStore closures{*pool};
  const storage::postgres::GraphStore graph_store{*pool};
  const storage::postgres::LinkPointStore link_points{*pool};
  const storage::postgres::RobotPoseStore robot_poses{*pool};
  const storage::ActivityStore activity{*pool};
  const storage::AuditStore audit{*pool};
  const storage::DoorVerdictStore door_verdicts{*pool};
  const storage::postgres::SiteLeaseStore site_leases{*pool, storage::SiteRight::kChange};
  const storage::postgres::SiteLeaseStore solver_leases{*pool, storage::SiteRight::kSolve};
  const storage::postgres::SurveyStore surveys{*pool};
  const storage::postgres::RearrangementStore rearrangement_store{*pool};
  const storage::PlanJoinStore plan_joins{*pool};
  const storage::FeatureStore features{*pool};
  const storage::Maintenance maintenance{*pool};
  const storage::SiteDeletion site_deletion{*pool};
  WakeSignal doors_wake;
  UploadSpace uploads{UploadSpaceOptionsOf(options), [this](const UploadSpace::Use& use) {
                        metrics->SetUploadsHeld(use.memory_bytes, use.disk_bytes);
                      }};
  Executor executor;
  Executor bulk{kBulkThreads, kMaxQueuedCalls};
  Executor slow{kSlowThreads, kMaxQueuedSlowCalls};
  Executor watches{kWatchThreads, kMaxQueuedCalls};
  Mapping mapping;
  Ingest ingest;
  PoseReports pose_reports;
  ChangedSites changed_sites;
  SiteGraphs graphs{graph_store, changed_sites};
  GraphVersionWaits graph_waits{graphs, std::chrono::milliseconds(std::llround(options.graph.version_wait_s * 1000.0))};
  PoseLooks pose_looks{graphs, robot_poses, PoseLooksOptionsOf(options)};
  MapEdits map_edits{map_edit_store, {blobs, revisions}, link_points};
  DraftPresences draft_presences;
  RasterPyramids raster_pyramids{revisions, pyramids, blobs, *metrics};
  const PriorAlignment prior_alignment{prior_maps, plan_joins, maps, revisions, blobs, graphs, ThreadsOfSlowCall()};
  const PlanLocalization plan_localization{{prior_maps, blobs, sessions, mappings, records},
                                           *slam_profiles.Find(slam::SlamProfiles::kIndoor)};
  SiteLooks site_looks{pose_looks, activity, {.timeout = StepTimeout(options)}};
  GraphEditor graph_editor{{maps, link_points, graph_store}, graphs};
  GraphOptimizer graph_optimizer{graph_store, {solver_leases, site_leases}, graphs, changed_sites};
  const Rearranger rearranger{
      {sessions, mappings, maps, revisions, blobs, rearrangement_store}, slam_profiles, graphs, &map_edits};
  const MapRearrangements rearrangements{{sessions, mappings, maps, revisions, blobs, rearrangement_store},
                                         site_leases,
                                         rearranger,
                                         graphs,
                                         options.closure.map_name};
  MapEntries map_entries{sessions, maps, door_verdicts};
  RobotLocalization localization{graphs, revisions, {link_points, blobs, features}};
  DoorClosures door_closures{
      options.closure,
      {sessions, records, mappings, blobs, features, maps, link_points, door_verdicts, site_leases},
      graphs,
      doors_wake,
      {.entered =
           [this] {
             mapping.Wake();
             map_entries.Wake();
           },
       .judged = [this] { survey_wake.Wake(); }}};
  PlanDoorJoiner plan_door_joiner{
      options.closure,
      {{sessions, records, mappings, blobs, features, maps, link_points, door_verdicts, site_leases},
       prior_maps,
       plan_joins},
      graphs,
      rearranger};
  WakeSignal survey_wake;
  std::unique_ptr<SiteSurveyor> surveyor;  // null: sites are not surveyed
  std::unique_ptr<MapExports> exports;
  std::unique_ptr<Readiness> readiness;
  std::unique_ptr<SiteDeletions> site_deletions;
  std::unique_ptr<Services> services;
  std::unique_ptr<Api> api;
  std::unique_ptr<MaintenanceLoop> maintenance_loop;
  std::unique_ptr<PlanRealigner> realigner;       // null: plans are not aligned again by themselves
  std::unique_ptr<MaintenanceLoop> realign_loop;  // on a thread of its own, because an alignment takes seconds
  std::unique_ptr<MaintenanceLoop> plan_doors_loop;
  std::string address;
  std::unique_ptr<grpc::Server> grpc;
};

Server::Server(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Server::~Server() { impl_->Shutdown(); }
const std::string& Server::address() const { return impl_->address; }
void Server::Shutdown() { impl_->Shutdown(); }

absl::StatusOr<std::unique_ptr<Server>> Server::Start(const ServerOptions& options, const slam::SlamProfiles& slam) {
  ENFILADE_RETURN_IF_ERROR(options.Validate());
  for (const std::string& name : slam.Names()) {
    const absl::Status status = slam.Find(name)->Validate();
    if (!status.ok()) return WithContext(status, "SLAM profile \"" + name + "\"");
  }
  ENFILADE_ASSIGN_OR_RETURN(auto pool, storage::postgres::Pool::Create(PoolOptionsOf(options.database)));
  ENFILADE_ASSIGN_OR_RETURN(auto metrics, Metrics::Create(options.metrics.address));
  auto impl = std::make_unique<Impl>(options, slam, std::move(pool), std::move(metrics));
  ENFILADE_RETURN_IF_ERROR(impl->Start());
  return std::unique_ptr<Server>(new Server(std::move(impl)));
}

}  // namespace enfilade::server
