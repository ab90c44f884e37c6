// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>

#include "absl/status/statusor.h"
#include "storage/call_context.h"

namespace enfilade::storage {
namespace postgres {
class Pool;
}

// What a call did.
struct MaintenancePortion {
  std::int64_t looked_at = 0;  // blobs that might be unused, maps that might have revisions to delete
  std::int64_t deleted = 0;    // rows
};

// Deletes what is no longer needed, in small transactions: each call deletes about `limit` rows at most and returns how
// many. Call it again while it returns `limit`. An error in one site does not stop the others: it is returned, naming
// the site, once they have nothing left to delete. Several replicas may do so at the same time. Thread-safe; errors
// common to all stores: see SiteStore.
class Maintenance {
 public:
  explicit Maintenance(postgres::Pool& pool) : pool_(pool) {}

  // Rows of deleted sessions.
  absl::StatusOr<std::int64_t> PurgeDeletedSessions(const CallContext& context, std::int64_t limit) const;
  // What is left of sessions that were deleted longer than `kept` ago: until then their late records are refused, and
  // their ids not used again. Those that a revision or a later session refers to stay.
  absl::StatusOr<std::int64_t> ForgetDeletedSessions(const CallContext& context, std::chrono::seconds kept,
                                                     std::int64_t limit) const;
  // Records older than their site's retention, counted from when the session was finished. Sessions that are recording
  // or not yet mapped keep theirs.
  absl::StatusOr<std::int64_t> DeleteExpiredRecords(const CallContext& context, std::int64_t limit) const;
  // The data for undoing rearrangements that were made longer than `kept` ago. They stay in the list and can no longer
  // be undone (RearrangementStore::Undo).
  absl::StatusOr<std::int64_t> DeleteExpiredUndo(const CallContext& context, std::chrono::seconds kept,
                                                 std::int64_t limit) const;
  // By the sites' retentions (Site). Finished sessions, which PurgeDeletedSessions then deletes.
  absl::StatusOr<std::int64_t> DeleteFinishedSessions(const CallContext& context, std::int64_t limit) const;
  // Revisions of maps. Looks at maps only that have got a revision, or whose next revision is due: call it again while
  // it looks at `limit` or deletes as many.
  absl::StatusOr<MaintenancePortion> DeleteRevisions(const CallContext& context, std::int64_t limit) const;
  // Versions of the graph, and what was removed from it. Who has a copy of the graph from before reads all of it again.
  absl::StatusOr<std::int64_t> DeleteGraphHistory(const CallContext& context, std::int64_t limit) const;
  absl::StatusOr<std::int64_t> DeleteAuditEntries(const CallContext& context, std::int64_t limit) const;
  // Blobs that nothing refers to and that were last put longer than `grace` ago: the time that a client may take from
  // sending a blob to sending the record that refers to it. Looks at no more than `limit` blobs, and at none that has
  // been in use since it was last looked at: call it again while it looks at `limit`. Replicas look at different ones.
  absl::StatusOr<MaintenancePortion> CollectBlobs(const CallContext& context, std::chrono::seconds grace,
                                                  std::int64_t limit) const;

 private:
  postgres::Pool& pool_;
};

}  // namespace enfilade::storage
