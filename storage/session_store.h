// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/base/time.h"
#include "core/sensor/session_entry.h"
#include "storage/call_context.h"

namespace enfilade::storage {
namespace postgres {
class Pool;
}

// The numbers are in the database: never reuse one.
enum class SessionState : std::int16_t {
  kRecording = 1,
  kFinished = 2,  // no more records will come; the rest is being mapped
  kMapped = 3,    // all is mapped, or there is no map to make
  kFailed = 4,    // mapping failed: see Session::error
};

struct RecordCounts {
  std::int64_t laser_scans = 0;
  std::int64_t odometry = 0;
  std::int64_t images = 0;
  std::int64_t point_clouds = 0;
  std::int64_t withheld = 0;
  std::int64_t door_reports = 0;

  friend bool operator==(const RecordCounts&, const RecordCounts&) = default;
};

// What became of the scans, as the mapping worker counts it.
struct MappingCounts {
  std::int64_t paired = 0;
  std::int64_t unpaired = 0;
  std::int64_t time_reversed = 0;
  std::int64_t used = 0;
  std::int64_t keyframes = 0;
  std::int64_t lost = 0;

  friend bool operator==(const MappingCounts&, const MappingCounts&) = default;
};

struct Session {
  SiteId site;
  SessionId id;
  RobotId robot;
  std::optional<MapId> map;  // unset: only recorded, or entry.previous is not judged yet
  sensor::SessionEntry entry;
  // Set by the store.
  SessionState state = SessionState::kRecording;
  std::int64_t acknowledged_sequence = 0;  // all records up to it are stored
  std::int64_t highest_sequence = 0;       // greater where there are holes
  std::int64_t mapped_sequence = 0;        // all records up to it are in the map
  RecordCounts record_counts;
  MappingCounts mapping_counts;
  std::int64_t payload_bytes = 0;    // of all records, without blobs
  std::optional<TimeNs> first_time;  // of the records
  std::optional<TimeNs> last_time;
  std::string error;
  bool records_deleted = false;  // by the site's retention
  TimeNs create_time = 0;
  std::optional<TimeNs> finish_time;
};

struct SessionFilter {
  std::optional<RobotId> robot;
  std::optional<MapId> map;
  std::optional<SessionState> state;
};

// A place in the list of sessions, which goes from the newest to the oldest.
struct SessionPosition {
  TimeNs create_time = 0;
  SessionId id;
};

// A session's log is written by RecordStore, its map by MappingStore. Thread-safe; errors common to all stores: see
// SiteStore.
class SessionStore {
 public:
  explicit SessionStore(postgres::Pool& pool) : pool_(pool) {}

  // Uses site, id, robot, map and entry. NOT_FOUND naming the site, robot, map or previous session that is missing;
  // ALREADY_EXISTS where the id is taken, also by a deleted session. `request_id` as in SiteStore.
  absl::StatusOr<Session> Create(const CallContext& context, const Session& session,
                                 const std::string& request_id) const;
  // NOT_FOUND, also for deleted sessions.
  absl::StatusOr<Session> Get(const CallContext& context, const SiteId& site, const SessionId& session) const;
  // Without the deleted ones, the newest first, behind `after` (unset: from the first).
  absl::StatusOr<std::vector<Session>> List(const CallContext& context, const SiteId& site, const SessionFilter& filter,
                                            int limit, const std::optional<SessionPosition>& after) const;
  // No more records will come: the state becomes kFinished, or kMapped where there is no map to make.
  // FAILED_PRECONDITION where the log has holes or does not end at `last_sequence` (0: nothing was recorded). Finishing
  // twice is no error. NOT_FOUND.
  absl::StatusOr<Session> Finish(const CallContext& context, const SiteId& site, const SessionId& session,
                                 std::int64_t last_sequence) const;
  // At once for all readers and writers; the lease on it is lost. The rows go later, by Maintenance; the id stays
  // known, so that late data are refused. Revisions made from it stay. NOT_FOUND, also the second time.
  absl::Status Delete(const CallContext& context, const SiteId& site, const SessionId& session) const;

 private:
  postgres::Pool& pool_;
};

}  // namespace enfilade::storage
