// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "core/base/ids.h"
#include "core/slam/slam_map.h"
#include "storage/call_context.h"
#include "storage/maps/blob_store.h"
#include "storage/maps/revision_store.h"
#include "storage/sessions/session_store.h"

namespace enfilade::storage {

// The right to map one session. The token grows with every holder and fences the earlier ones: what they write under
// their lease is refused.
struct SessionLease {
  SiteId site;
  SessionId session;
  std::string owner;
  std::int64_t token = 0;
  TimeNs take_time = 0;                    // when it was taken, by the database's clock
  std::int64_t acknowledged_sequence = 0;  // of the session, then
};

struct LeasedSession {
  SessionLease lease;
  Session session;
  // How often the session has been taken since it was last released, this time included. Above 1: the holders before
  // did not come to the end of their turn.
  std::int64_t attempts = 1;
};

// What a mapping worker stores in one transaction. The referenced values must live until the call returns.
struct MappingStep {
  const slam::SlamDelta& delta;
  std::string_view checkpoint;              // state of the scan pairing and the mapper after the delta
  MappingCounts counts;                     // of all steps so far
  std::int64_t mapped_sequence = 0;         // all records up to it are in the map or in the checkpoint
  const NewRevision* revision = nullptr;    // a new revision of the session's map, if due
  absl::Span<const BlobView> blobs;         // its blobs that may not be stored yet
  std::optional<SessionState> final_state;  // kMapped or kFailed ends the session's mapping
  std::string error;                        // with kFailed
};

// How far a session is when a step is stored.
struct MappingProgress {
  SessionState state = SessionState::kRecording;
  std::int64_t mapped_sequence = 0;
};
// INVALID_ARGUMENT if the step goes back or its final state is not final; FAILED_PRECONDITION if it ends the mapping of
// a session that may still get records.
absl::Status ValidateStep(const SessionLease& lease, const MappingProgress& progress, const MappingStep& step);

// Whether a session has acknowledged records after `read_sequence` that are not mapped, or is finished and has to be
// closed.
bool IsToBeMapped(const Session& session, std::int64_t read_sequence);

// The sessions that wait to be mapped, those that are being mapped included.
struct MappingBacklog {
  std::int64_t sessions = 0;
  double oldest_s = 0.0;  // for how long, at most, the record has waited that has waited longest; 0: none waits
  // Sessions that have no map until the door is judged through which they came from a session that has ended, and for
  // how long the longest of them has waited since that one's end.
  std::int64_t without_map = 0;
  double longest_without_map_s = 0.0;
};

// ABORTED: another holder has taken over.
absl::Status LeaseLost(const SessionLease& lease);

struct StoredMapping {
  slam::SlamMap map;
  std::string checkpoint;
  std::int64_t mapped_sequence = 0;
};

struct Trajectory {
  std::int64_t mapped_sequence = 0;      // the last record that it was made from
  std::vector<slam::StampedPose> poses;  // in the order of the log
};

// Leases on sessions, and what mapping makes of them. Leases expire by the database's clock. Thread-safe; errors common
// to all stores: see SiteStore.
class MappingStore {
 public:
  virtual ~MappingStore() = default;

  // A session of any site that nobody holds and that has records to map, or is finished and has to be closed: the one
  // that has waited longest for its turn. Unset if there is none. Costs the same however many sessions have nothing to
  // map.
  virtual absl::StatusOr<std::optional<LeasedSession>> Acquire(const CallContext& context, const std::string& owner,
                                                               std::chrono::milliseconds ttl) const = 0;
  // Extends the lease to `ttl` from now. ABORTED if another holder has taken over or the session is deleted.
  virtual absl::Status Renew(const CallContext& context, const SessionLease& lease,
                             std::chrono::milliseconds ttl) const = 0;
  // Makes the lease available, and begins the count of attempts anew. The holder has read all records up to
  // `read_sequence`: if those are all, and the session is not finished, it is found again when more come; otherwise it
  // waits for its next turn. Releasing a lost lease is no error.
  virtual absl::Status Release(const CallContext& context, const SessionLease& lease,
                               std::int64_t read_sequence) const = 0;
  // Acquire finds the session again if it has records that are not mapped: what the holder before read, but did not
  // store. A session that does not exist is no error.
  virtual absl::Status Queue(const CallContext& context, const SiteId& site, const SessionId& session) const = 0;
  virtual absl::StatusOr<MappingBacklog> GetBacklog(const CallContext& context) const = 0;

  // Stores the delta's rows, the checkpoint, the revision and the session's final state in one transaction. Returns the
  // revision's number, 0 without one. ABORTED if the lease is lost: the worker must stop. ABORTED with AreLayersChanged
  // if other layers of the map have changed since step.revision was made from them. FAILED_PRECONDITION if kMapped is
  // set before the session is finished, or a tile's blob or a row that the delta refers to is missing. INVALID_ARGUMENT
  // if mapped_sequence decreases. On any error nothing is stored. A retry after UNAVAILABLE is safe: storing the same
  // step again changes nothing.
  virtual absl::StatusOr<std::int64_t> Commit(const CallContext& context, const SessionLease& lease,
                                              const MappingStep& step) const = 0;

  // The sum of all steps so far, with submap contents; unset before the first.
  virtual absl::StatusOr<std::optional<StoredMapping>> Load(const CallContext& context, const SiteId& site,
                                                            const SessionId& session) const = 0;

  // All poses by the current estimate, consistent with one step. Empty before the first step; NOT_FOUND if the session
  // does not exist.
  virtual absl::StatusOr<Trajectory> ReadTrajectory(const CallContext& context, const SiteId& site,
                                                    const SessionId& session) const = 0;

  // The current keyframes, by id. Empty before the first step, and if the session does not exist.
  virtual absl::StatusOr<std::vector<slam::SlamNode>> ListKeyframes(const CallContext& context, const SiteId& site,
                                                                    const SessionId& session) const = 0;
  // T_map_robot of the keyframe nearest in time; unset if there is none.
  virtual absl::StatusOr<std::optional<PoseWithCovariance>> FindKeyframe(const CallContext& context, const SiteId& site,
                                                                         const SessionId& session,
                                                                         TimeNs time) const = 0;
};

}  // namespace enfilade::storage
