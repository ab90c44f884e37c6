// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/base/time.h"
#include "storage/call_context.h"
#include "storage/sessions/session_store.h"

namespace enfilade::storage {
namespace postgres {
class Pool;
}

// How far a session has come.
struct SessionProgress {
  SessionId id;
  RobotId robot;  // empty if it was deleted
  std::optional<MapId> map;
  SessionState state = SessionState::kRecording;
  std::int64_t acknowledged_sequence = 0;
  std::int64_t mapped_sequence = 0;
  std::string error;
  std::optional<TimeNs> finish_time;
  bool deleted = false;

  // It may get records or wait for mapping.
  bool is_over() const {
    return deleted ||
           (finish_time.has_value() && state != SessionState::kRecording && state != SessionState::kFinished);
  }

  friend bool operator==(const SessionProgress&, const SessionProgress&) = default;
};

// The current revision of a map.
struct CurrentRevision {
  MapId map;
  std::int64_t number = 0;
  TimeNs create_time = 0;

  friend bool operator==(const CurrentRevision&, const CurrentRevision&) = default;
};

// What goes on at a site. Times are by the database's clock.
struct SiteActivity {
  TimeNs time = 0;  // when it was read
  TimeNs site_created = 0;
  std::vector<CurrentRevision> revisions;   // by map
  std::vector<SessionProgress> sessions;    // by id
  std::vector<SessionId> removed_sessions;  // by id
  std::int64_t waiting_sessions = 0;        // to be mapped
  double mapping_lag_s = 0.0;               // for how long the record has waited that has waited longest
};

// What to read beside the sessions that are not over.
struct ActivityQuery {
  std::vector<SessionId> also;  // as they are now, deleted ones included
  TimeNs since = 0;             // those that were finished since, and in removed_sessions those deleted; 0: none
};

// What has gone or come to its end since a time.
struct PastActivity {
  std::vector<SessionProgress> ended;  // by id; those that were deleted since are in `removed_sessions`
  std::vector<SessionId> removed_sessions;
  std::vector<RobotId> removed_robots;  // without those that have a pose again
};

// Reads at once what people who look at a site want to know. Thread-safe; errors common to all stores: see SiteStore.
class ActivityStore {
 public:
  explicit ActivityStore(postgres::Pool& pool) : pool_(pool) {}

  // NOT_FOUND if the site does not exist.
  absl::StatusOr<SiteActivity> Read(const CallContext& context, const SiteId& site, const ActivityQuery& query) const;
  // What was deleted since `since`, and the sessions that were finished since `finished_since` and are over, at most
  // `limit` of them: the last ones.
  absl::StatusOr<PastActivity> ReadPast(const CallContext& context, const SiteId& site, TimeNs since,
                                        TimeNs finished_since, int limit) const;

 private:
  postgres::Pool& pool_;
};

}  // namespace enfilade::storage
