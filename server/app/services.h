#pragma once

#include <chrono>

#include "server/app/closure/map_entries.h"
#include "server/app/executor.h"
#include "server/app/graph/graph_optimizer.h"
#include "server/app/graph/site_graphs.h"
#include "server/app/ingest.h"
#include "server/app/map_exports.h"
#include "server/app/mapping.h"
#include "server/app/metrics.h"
#include "server/app/readiness.h"
#include "server/config/server_options.h"
#include "storage/audit_store.h"
#include "storage/blob_store.h"
#include "storage/closure_store.h"
#include "storage/door_verdict_store.h"
#include "storage/graph_store.h"
#include "storage/link_point_store.h"
#include "storage/map_store.h"
#include "storage/mapping_store.h"
#include "storage/record_store.h"
#include "storage/revision_store.h"
#include "storage/robot_pose_store.h"
#include "storage/robot_store.h"
#include "storage/session_store.h"
#include "storage/site_store.h"

namespace enfilade::server {

// All that the RPCs see of the server. Everything in it is thread-safe and outlives every call.
struct Services {
  const ServerOptions& options;
  std::chrono::steady_clock::time_point start_time;
  Executor& executor;
  Metrics& metrics;
  const Readiness& readiness;

  const SiteStore& sites;
  const RobotStore& robots;
  const MapStore& maps;
  const RevisionStore& revisions;
  const SessionStore& sessions;
  const RecordStore& records;
  const BlobStore& blobs;
  const MappingStore& mappings;
  const ClosureStore& closures;
  const LinkPointStore& link_points;
  const GraphStore& graph_store;
  const RobotPoseStore& robot_poses;
  const AuditStore& audit;
  const DoorVerdictStore& door_verdicts;

  Ingest& ingest;
  Mapping& mapping;
  MapExports& exports;
  SiteGraphs& graphs;
  GraphOptimizer& graph_optimizer;
  MapEntries& map_entries;
};

}  // namespace enfilade::server
