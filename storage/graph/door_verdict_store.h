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
#include "storage/graph/link_point_store.h"
#include "storage/graph/site_lease_store.h"
#include "storage/maps/map_store.h"
#include "storage/sessions/session_store.h"

namespace enfilade::storage {
namespace postgres {
class Pool;
}

// A session with doors to judge, or with a passage that another session waits for.
struct PendingDoors {
  SiteId site;
  SessionId session;

  friend bool operator==(const PendingDoors&, const PendingDoors&) = default;
};

// What is not to be looked for now.
struct PostponedDoors {
  std::vector<PendingDoors> sessions = {};
  std::vector<SiteId> sites = {};
};

struct StoredDoorReport {
  std::int64_t sequence = 0;
  sensor::DoorReport report;
  bool judged = false;
  std::optional<Pose2> T_odom_robot;  // at report.time, as the verdict has it
};

// What a candidate was made for.
struct CandidateReport {
  LinkPointId candidate;
  sensor::DoorReport report;
};

// A map that starts at a door. Its display name is `name_prefix` and a free number, the one before which is taken.
struct NewMap {
  MapId id;
  std::string name_prefix;
  int level = 0;
  Environment environment = Environment::kIndoor;
  std::string slam_profile;
};

// All changes that follow from one report, in the lease's site.
struct DoorChange {
  closure::DoorVerdict verdict;                   // the graph must still be at its graph_version
  std::optional<NewMap> new_map;                  // of verdict.entered_map
  std::optional<StoredLinkPoint> new_link_point;  // or candidate
  std::optional<StoredLinkPoint> link_point;      // an existing one after the change, with its etag
  std::vector<LinkPointId> consumed;              // candidates that the link point replaces
  std::vector<Evidence> evidence;                 // replaces the anchors' evidence of these kinds
};

// Where sessions that wait for a passage are if no verdict says so.
struct EnteredMap {
  SessionId previous;
  std::optional<NewMap> new_map;  // of `map`
  MapId map;
  std::optional<PoseWithCovariance> T_map_robot;  // unset: the map starts with the session
  std::optional<Pose2> T_odom_robot;
};

// Door reports, the verdicts on them, and the sessions that wait for a verdict. Thread-safe; errors common to all
// stores: see SiteStore.
class DoorVerdictStore {
 public:
  explicit DoorVerdictStore(postgres::Pool& pool) : pool_(pool) {}

  // Of all sites: sessions that are finished and mapped (or failed) with reports that are not judged, and those with a
  // passage that a session waits for. The longest waiting of each site first, then each site's second, and so on.
  absl::StatusOr<std::vector<PendingDoors>> FindPending(const CallContext& context, int limit,
                                                        const PostponedDoors& postponed = {}) const;
  // In the order of the log. DATA_LOSS if a report does not decode.
  absl::StatusOr<std::vector<StoredDoorReport>> ReadReports(const CallContext& context, const SiteId& site,
                                                            const SessionId& session) const;
  // Of all link points that were made as candidates, as far as retention has kept the reports. DATA_LOSS as above.
  absl::StatusOr<std::vector<CandidateReport>> ListCandidateReports(const CallContext& context,
                                                                    const SiteId& site) const;
  // Sessions that wait for the passage at the end of `previous`.
  absl::StatusOr<std::vector<SessionId>> ListWaiting(const CallContext& context, const SiteId& site,
                                                     const SessionId& previous) const;

  // Stores maps, link points, evidence, the verdict, and the map and pose of all sessions that wait for it in one
  // transaction. No-op if the report has been judged. ABORTED if the lease is lost or the graph is no longer at
  // verdict.graph_version; ALREADY_EXISTS if the link point is redundant; NOT_FOUND.
  absl::Status Commit(const CallContext& context, const SiteLease& lease, const DoorChange& change) const;
  // Gives the sessions that wait for `entered.previous` their map. ABORTED if the lease is lost; NOT_FOUND if the map
  // does not exist.
  absl::Status Enter(const CallContext& context, const SiteLease& lease, const EnteredMap& entered) const;
  // Marks all reports of the session as judged. ABORTED if the lease is lost.
  absl::Status MarkJudged(const CallContext& context, const SiteLease& lease, const SessionId& session) const;

  // By sequence, those after `after`. NOT_FOUND if the session does not exist.
  absl::StatusOr<std::vector<closure::DoorVerdict>> List(const CallContext& context, const SiteId& site,
                                                         const SessionId& session, std::int64_t after, int limit) const;
  // On the passage at the end of the session; unset if there is none, or it is not judged.
  absl::StatusOr<std::optional<closure::DoorVerdict>> FindPassage(const CallContext& context, const SiteId& site,
                                                                  const SessionId& session) const;

  // Those on passages into `map`, latest first, without their comparisons.
  absl::StatusOr<std::vector<closure::DoorVerdict>> ListInto(const CallContext& context, const SiteId& site,
                                                             const MapId& map, int limit) const;

 private:
  postgres::Pool& pool_;
};

}  // namespace enfilade::storage
