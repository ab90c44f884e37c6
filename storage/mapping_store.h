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
#include "storage/blob_store.h"
#include "storage/call_context.h"
#include "storage/revision_store.h"
#include "storage/session_store.h"

namespace enfilade::storage {
namespace postgres {
class Pool;
}

// The right to map one session. Of two holders the one with the lower token has lost it: all that it still writes is
// refused.
struct SessionLease {
  SiteId site;
  SessionId session;
  std::string owner;
  std::int64_t token = 0;
};

struct LeasedSession {
  SessionLease lease;
  Session session;
};

// What a mapping worker has to store at once. The referred values must live until the call returns.
struct MappingStep {
  const slam::SlamDelta& delta;
  std::string_view checkpoint;              // pairing's and mapper's state after the delta
  MappingCounts counts;                     // of all steps so far
  std::int64_t mapped_sequence = 0;         // all records up to it are in the map or in the checkpoint
  const NewRevision* revision = nullptr;    // a new revision of the session's map, where due
  absl::Span<const BlobView> blobs;         // its blobs that may not be stored yet
  std::optional<SessionState> final_state;  // kMapped or kFailed ends the session's mapping
  std::string error;                        // with kFailed
};

struct StoredMapping {
  slam::SlamMap map;
  std::string checkpoint;
  std::int64_t mapped_sequence = 0;
};

struct Trajectory {
  std::int64_t mapped_sequence = 0;      // the log up to which it was made from
  std::vector<slam::StampedPose> poses;  // in the order of the log
};

// Thread-safe; errors common to all stores: see SiteStore. Leases run on the database's clock.
class MappingStore {
 public:
  explicit MappingStore(postgres::Pool& pool) : pool_(pool) {}

  // A session of any site that has records to be mapped (or is finished and only has to be closed) and that nobody
  // holds: the one that waits longest. Unset where there is none.
  absl::StatusOr<std::optional<LeasedSession>> Acquire(const CallContext& context, const std::string& owner,
                                                       std::chrono::milliseconds ttl) const;
  // Holds for `ttl` from now. ABORTED where another holder has taken over or the session is deleted.
  absl::Status Renew(const CallContext& context, const SessionLease& lease, std::chrono::milliseconds ttl) const;
  // Others may acquire at once. Releasing a lost lease is no error.
  absl::Status Release(const CallContext& context, const SessionLease& lease) const;

  // One transaction: the delta's rows, the checkpoint, the revision (its number is returned, 0 without one) and the
  // session's final state. ABORTED where the lease is lost: the worker must stop; or, with AreLayersChanged, where
  // other layers of the map have changed since step.revision was laid together: then nothing is stored.
  // INVALID_ARGUMENT where mapped_sequence goes backwards. A retry after UNAVAILABLE is safe: a step whose
  // mapped_sequence and checkpoint are stored already under this token changes nothing.
  absl::StatusOr<std::int64_t> Commit(const CallContext& context, const SessionLease& lease,
                                      const MappingStep& step) const;

  // All that the steps so far have stored, with submap contents; unset before the first.
  absl::StatusOr<std::optional<StoredMapping>> Load(const CallContext& context, const SiteId& site,
                                                    const SessionId& session) const;

  // All poses by the present estimate, of one moment. Empty before the first step; NOT_FOUND where the session is
  // missing.
  absl::StatusOr<Trajectory> ReadTrajectory(const CallContext& context, const SiteId& site,
                                            const SessionId& session) const;

  // By id, as they are now. Empty before the first step, and where the session is missing.
  absl::StatusOr<std::vector<slam::SlamNode>> ListKeyframes(const CallContext& context, const SiteId& site,
                                                            const SessionId& session) const;
  // The keyframe nearest in time; unset where there is none.
  absl::StatusOr<std::optional<PoseWithCovariance>> FindKeyframe(const CallContext& context, const SiteId& site,
                                                                 const SessionId& session, TimeNs time) const;

 private:
  postgres::Pool& pool_;
};

}  // namespace enfilade::storage
