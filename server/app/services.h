// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

#include "server/app/closure/map_entries.h"
#include "server/app/edits/draft_presences.h"
#include "server/app/edits/map_edits.h"
#include "server/app/exports/map_exports.h"
#include "server/app/graph/graph_editor.h"
#include "server/app/graph/graph_optimizer.h"
#include "server/app/graph/graph_version_waits.h"
#include "server/app/graph/pose_looks.h"
#include "server/app/graph/site_graphs.h"
#include "server/app/ingest/ingest.h"
#include "server/app/ingest/pose_reports.h"
#include "server/app/localization/robot_localization.h"
#include "server/app/mapping/mapping.h"
#include "server/app/priors/plan_localization.h"
#include "server/app/priors/prior_alignment.h"
#include "server/app/rasters/raster_pyramids.h"
#include "server/app/rearrange/map_rearrangements.h"
#include "server/app/runtime/executor.h"
#include "server/app/runtime/metrics.h"
#include "server/app/runtime/readiness.h"
#include "server/app/runtime/wake_signal.h"
#include "server/app/sites/site_deletions.h"
#include "server/app/uploads/upload_space.h"
#include "server/app/watch/site_looks.h"
#include "server/config/server_options.h"
#include "storage/graph/door_verdict_store.h"
#include "storage/graph/graph_store.h"
#include "storage/graph/link_point_store.h"
#include "storage/graph/plan_join_store.h"
#include "storage/graph/rearrangement_store.h"
#include "storage/graph/robot_pose_store.h"
#include "storage/maps/blob_store.h"
#include "storage/maps/map_alias_store.h"
#include "storage/maps/map_area_store.h"
#include "storage/maps/map_edit_store.h"
#include "storage/maps/map_store.h"
#include "storage/maps/prior_map_store.h"
#include "storage/maps/pyramid_store.h"
#include "storage/maps/revision_store.h"
#include "storage/sessions/loop_closure_store.h"
#include "storage/sessions/mapping_store.h"
#include "storage/sessions/record_store.h"
#include "storage/sessions/session_store.h"
#include "storage/sites/activity_store.h"
#include "storage/sites/audit_store.h"
#include "storage/sites/robot_store.h"
#include "storage/sites/site_store.h"

namespace enfilade::server {

// What the RPCs see of the server. All members are thread-safe and outlive every call.
struct Services {
  const ServerOptions& options;
  std::chrono::steady_clock::time_point start_time;
  Executor& executor;
  Executor& bulk;     // makes large answers
  Executor& slow;     // calls that compute for seconds
  Executor& watches;  // makes messages of watches
  Metrics& metrics;
  const Readiness& readiness;

  // Maps, link points and the graph are changed by graph_editor and rearrangements.
  const storage::SiteStore& sites;
  const storage::RobotStore& robots;
  const storage::MapReader& maps;
  const storage::MapAreaStore& map_areas;
  const storage::RevisionStore& revisions;
  const storage::MapAliasStore& map_aliases;
  const storage::PyramidStore& pyramids;
  const storage::MapEditStore& map_edit_store;
  const storage::PriorMapStore& prior_maps;
  const storage::SessionStore& sessions;
  const storage::RecordStore& records;
  const storage::BlobStore& blobs;
  const storage::MappingStore& mappings;
  const storage::LoopClosureStore& closures;
  const storage::LinkPointReader& link_points;
  const storage::GraphReader& graph_store;
  const storage::RobotPoseStore& robot_poses;
  const storage::ActivityStore& activity;
  const storage::AuditStore& audit;
  const storage::DoorVerdictStore& door_verdicts;
  const storage::RearrangementStore& rearrangement_store;
  const storage::PlanJoinStore& plan_joins;

  UploadSpace& uploads;
  Ingest& ingest;
  PoseReports& pose_reports;
  Mapping& mapping;
  WakeSignal& doors_wake;  // a session may be waiting for a verdict
  MapExports& exports;
  MapEdits& map_edits;
  DraftPresences& draft_presences;
  RasterPyramids& raster_pyramids;
  const PriorAlignment& prior_alignment;
  const PlanLocalization& plan_localization;
  SiteGraphs& graphs;
  GraphVersionWaits& graph_waits;
  PoseLooks& pose_looks;
  SiteLooks& site_looks;
  GraphEditor& graph_editor;
  GraphOptimizer& graph_optimizer;
  MapEntries& map_entries;
  const MapRearrangements& rearrangements;
  RobotLocalization& localization;
  SiteDeletions& site_deletions;
};

}  // namespace enfilade::server
