// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/environment.h"
#include "core/base/ids.h"
#include "core/closure/door_verdict.h"
#include "core/sensor/record.h"
#include "storage/call_context.h"
#include "storage/link_point_store.h"
#include "storage/map_store.h"
#include "storage/session_store.h"
#include "storage/site_lease_store.h"

namespace enfilade::storage {
namespace postgres {
class Pool;
}

// A session whose doors are to be judged, or out of which others wait for their map.
struct PendingDoors {
  SiteId site;
  SessionId session;

  friend bool operator==(const PendingDoors&, const PendingDoors&) = default;
};

struct StoredDoorReport {
  std::int64_t sequence = 0;
  sensor::DoorReport report;
  bool judged = false;
};

// A map that begins at a door. Its display name is `name_prefix` and the least number that is free.
struct NewMap {
  MapId id;
  std::string name_prefix;
  int level = 0;
  Environment environment = Environment::kIndoor;
  std::string slam_profile;
};

// All that follows from one report. Its site is that of the lease.
struct DoorChange {
  closure::DoorVerdict verdict;                   // graph_version: the graph must still be at it
  std::optional<NewMap> new_map;                  // of verdict.entered_map
  std::optional<StoredLinkPoint> new_link_point;  // or candidate
  std::optional<StoredLinkPoint> link_point;      // one that is there, as it is to be; with its etag
  std::vector<LinkPointId> consumed;              // candidates that the link point takes the place of
  std::vector<Evidence> evidence;                 // takes the place of what the anchors had of these kinds
};

// Where the next sessions are, where no verdict says so.
struct EnteredMap {
  SessionId previous;
  std::optional<NewMap> new_map;  // of `map`
  MapId map;
  std::optional<PoseWithCovariance> T_map_robot;  // unset: the map begins with the session
  std::optional<Pose2> T_odom_robot;
};

// Door reports, what was made of them, and the sessions that wait for it. Thread-safe; errors common to all stores: see
// SiteStore.
class DoorVerdictStore {
 public:
  explicit DoorVerdictStore(postgres::Pool& pool) : pool_(pool) {}

  // Of all sites: sessions that are finished and mapped (or failed) with reports that are not judged, and those out of
  // which a session waits. The longest waiting first.
  absl::StatusOr<std::vector<PendingDoors>> FindPending(const CallContext& context, int limit) const;
  // In the order of the log. DATA_LOSS where a report does not decode.
  absl::StatusOr<std::vector<StoredDoorReport>> ReadReports(const CallContext& context, const SiteId& site,
                                                            const SessionId& session) const;
  // Sessions that wait for what `previous` ends with.
  absl::StatusOr<std::vector<SessionId>> ListWaiting(const CallContext& context, const SiteId& site,
                                                     const SessionId& previous) const;

  // One transaction: maps, link points and evidence, the verdict, and the map and pose of all sessions that wait for
  // it. Nothing happens where the report has been judged. ABORTED where the lease is lost or the graph is no longer at
  // verdict.graph_version; ALREADY_EXISTS where the link point is redundant; NOT_FOUND.
  absl::Status Commit(const CallContext& context, const SiteLease& lease, const DoorChange& change) const;
  // Gives those that wait for `entered.previous` their map. ABORTED where the lease is lost; NOT_FOUND where the map is
  // gone.
  absl::Status Enter(const CallContext& context, const SiteLease& lease, const EnteredMap& entered) const;
  // All reports of the session are judged. ABORTED where the lease is lost.
  absl::Status MarkJudged(const CallContext& context, const SiteLease& lease, const SessionId& session) const;

  // By sequence, those behind `after`. NOT_FOUND where the session is missing.
  absl::StatusOr<std::vector<closure::DoorVerdict>> List(const CallContext& context, const SiteId& site,
                                                         const SessionId& session, std::int64_t after, int limit) const;
  // On the passage that the session ends with; unset where there is none, or it is not judged.
  absl::StatusOr<std::optional<closure::DoorVerdict>> FindPassage(const CallContext& context, const SiteId& site,
                                                                  const SessionId& session) const;

  // Those on passages into `map`, the latest first, without their comparisons.
  absl::StatusOr<std::vector<closure::DoorVerdict>> ListInto(const CallContext& context, const SiteId& site,
                                                             const MapId& map, int limit) const;

 private:
  postgres::Pool& pool_;
};

}  // namespace enfilade::storage
