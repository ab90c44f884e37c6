// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "storage/graph/graph_store.h"
#include "storage/graph/link_point_store.h"
#include "storage/graph/rearrangement_store.h"
#include "storage/graph/robot_pose_store.h"
#include "storage/maps/map_store.h"
#include "storage/maps/revision_store.h"
#include "storage/sessions/mapping_store.h"
#include "storage/sessions/record_store.h"
#include "storage/sessions/session_store.h"

namespace enfilade::testing {

// The rows behind the in-memory stores.

struct LeaseRow {
  std::string owner;
  std::int64_t token = 0;  // 0: never held
  std::chrono::steady_clock::time_point expires_at;
  std::int64_t attempts = 0;  // of mapping, since the last release
};

// Of a session that waits to be mapped.
struct WorkRow {
  std::chrono::steady_clock::time_point waiting_since;
  std::chrono::steady_clock::time_point turn_time;
};

struct RecordRow {
  sensor::RecordKind kind = sensor::RecordKind::kWithheld;
  TimeNs time = 0;
  std::string payload;
};

struct SessionRow {
  storage::Session session;  // without the progress of its mapping
  storage::RequestId request_id;
  bool deleted = false;
  std::map<std::int64_t, RecordRow> records;
  std::chrono::steady_clock::time_point append_time;  // when the last records came, or it was made
  LeaseRow lease;
  std::optional<WorkRow> work;
  std::optional<storage::StoredMapping> mapping;
  storage::MappingCounts counts;
  std::optional<SessionId> cut_from;              // of a rest: the session in which it was recorded
  std::optional<std::int64_t> recorded_sequence;  // of the last record as it was recorded; unset: never cut
};

struct RevisionRow {
  storage::MapRevision revision;
  std::map<storage::TileKey, std::string> tiles;  // SHA-256
};

struct MapRow {
  storage::Map map;
  storage::RequestId request_id;
  std::vector<RevisionRow> revisions;     // number 1, 2, ...
  std::int64_t layers_version = 0;        // counts changes of layers, also of those that went
  std::vector<storage::MapLayer> layers;  // from the bottom
  std::vector<storage::NewLayerRun> runs;
  std::optional<rearrange::MapRedirect> redirect;
};

struct GraphMapRow {
  std::optional<PoseWithCovariance> T_world_map;
  std::int64_t changed_version = 0;
};

struct LinkPointRow {
  storage::StoredLinkPoint link_point;  // graph_version: when it last changed
  storage::RequestId request_id;
  std::vector<storage::Evidence> evidence;
};

struct GraphRows {
  std::int64_t version = 0;
  MapId root;
  std::map<MapId, GraphMapRow> maps;
  std::map<LinkPointId, LinkPointRow> link_points;
  std::map<MapId, std::int64_t> removed_maps;  // and the version that removed them
  std::map<LinkPointId, std::int64_t> removed_link_points;
  std::map<std::int64_t, storage::GraphVersion> versions;
  // What each optimisation changed; unset: it no longer poses the map.
  std::map<std::int64_t, std::map<MapId, std::optional<PoseWithCovariance>>> map_poses;
  std::vector<storage::ControlPoint> control_points;
};

// Rows as they were before a rearrangement; unset: there was none.
struct RowsBefore {
  std::map<MapId, std::optional<MapRow>> maps;
  std::map<MapId, std::optional<GraphMapRow>> places;
  std::map<SessionId, std::optional<SessionRow>> sessions;
  std::map<LinkPointId, std::optional<LinkPointRow>> link_points;
  std::map<RobotId, storage::RobotPose> robot_poses;
  std::vector<storage::ControlPoint> control_points;
};

struct RearrangementRow {
  storage::StoredRearrangement stored;
  std::map<SessionId, MapId> sources;  // the maps that the sessions left
  RowsBefore before;
  // What was changed, as it was left: texts by relation and key (rearrangement_journal.h).
  std::map<std::pair<std::string, std::string>, std::string> images_before, images_after;
  std::map<RobotId, std::int64_t> moved_robot_poses;  // and the version that moving them made
};

struct SiteRows {
  std::set<RobotId> robots;
  std::map<MapId, MapRow> maps;
  std::map<SessionId, SessionRow> sessions;
  std::map<std::string, std::string, std::less<>> blobs;  // by SHA-256
  std::map<RobotId, storage::RobotPose> robot_poses;
  GraphRows graph;
  std::map<rearrange::RearrangementId, RearrangementRow> rearrangements;
  LeaseRow lease;
  LeaseRow solver_lease;
};

using Tables = std::map<SiteId, SiteRows>;

}  // namespace enfilade::testing
