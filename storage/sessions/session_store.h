// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
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
#include "storage/request_id.h"

namespace enfilade::storage {
// The numbers are in the database: never reuse one.
enum class SessionState : std::int16_t {
  kRecording = 1,
  kFinished = 2,  // no more records will come; the rest is being mapped
  kMapped = 3,    // all records are mapped, or the session has no map
  kFailed = 4,    // mapping failed, or nobody finished it: see Session::error
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

// How the mapping worker has used the scans.
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
  std::optional<MapId> map;  // unset: only recorded, or the passage out of entry.previous is not judged yet
  sensor::SessionEntry entry;
  // Set by the store.
  SessionState state = SessionState::kRecording;
  std::int64_t acknowledged_sequence = 0;  // all records up to it are stored
  std::int64_t highest_sequence = 0;       // greater if there are holes
  std::int64_t mapped_sequence = 0;        // all records up to it are in the map
  RecordCounts record_counts;
  MappingCounts mapping_counts;
  std::int64_t payload_bytes = 0;    // of all records, without blobs
  std::optional<TimeNs> first_time;  // of the records
  std::optional<TimeNs> last_time;
  std::string error;
  bool records_deleted = false;  // by the site's retention
  bool doors_judged = false;     // all door reports; see DoorVerdictStore
  bool surveyed = false;         // see SurveyStore
  TimeNs create_time = 0;
  std::optional<TimeNs> finish_time;
};

struct SessionFilter {
  std::optional<RobotId> robot;
  std::optional<MapId> map;
  std::optional<SessionState> state;
};

// A position in the list of sessions, newest first.
struct SessionPosition {
  TimeNs create_time = 0;
  SessionId id;
};

struct ClosedSessions {
  std::int64_t finished = 0;
  std::int64_t failed = 0;
};

// RecordStore writes a session's log, MappingStore its map. Thread-safe; errors common to all stores: see SiteStore.
class SessionStore {
 public:
  virtual ~SessionStore() = default;

  // Uses site, id, robot, map and entry. If the previous session has been cut since, the new one follows its last
  // piece. NOT_FOUND naming the site, robot, map or previous session that is missing; ALREADY_EXISTS if the id is
  // taken, also by a deleted session; INVALID_ARGUMENT if the entry pose's covariance is invalid. `request_id` as in
  // SiteStore.
  virtual absl::StatusOr<Session> Create(const CallContext& context, const Session& session,
                                         const RequestId& request_id) const = 0;
  // NOT_FOUND, also for deleted sessions.
  virtual absl::StatusOr<Session> Get(const CallContext& context, const SiteId& site,
                                      const SessionId& session) const = 0;
  // Without the deleted ones, newest first, those after `after` (unset: from the first).
  virtual absl::StatusOr<std::vector<Session>> List(const CallContext& context, const SiteId& site,
                                                    const SessionFilter& filter, int limit,
                                                    const std::optional<SessionPosition>& after) const = 0;
  // No more records will come: the state becomes kFinished, or kMapped if there is nothing to map. FAILED_PRECONDITION
  // if the log has holes or does not end at `last_sequence` (0: nothing was recorded). Finishing twice is no error.
  // NOT_FOUND.
  virtual absl::StatusOr<Session> Finish(const CallContext& context, const SiteId& site, const SessionId& session,
                                         std::int64_t last_sequence) const = 0;
  // Closes up to `limit` sessions of all sites that nobody has finished and that got no record for `idle`: they take no
  // more records. They are finished where their logs end, as by Finish; those with holes have failed, with the reason;
  // those whose mapping has failed stay failed. An error in one site does not stop the others: it is returned, naming
  // the site, if nothing else could be closed.
  virtual absl::StatusOr<ClosedSessions> CloseIdle(const CallContext& context, std::chrono::seconds idle,
                                                   std::int64_t limit) const = 0;
  // Takes effect immediately for all readers and writers; the lease on the session is lost. Maintenance removes the
  // rows later. The id stays reserved so that late records are refused. Revisions made from the session stay.
  // NOT_FOUND, also the second time.
  virtual absl::Status Delete(const CallContext& context, const SiteId& site, const SessionId& session) const = 0;
};

}  // namespace enfilade::storage
