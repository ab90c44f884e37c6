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

// Removes what is no longer wanted, in small transactions: each call deletes at most about `limit` rows and returns how
// many it did; call again while that is `limit`. Any number of replicas may do so at once. Thread-safe; errors common
// to all stores: see SiteStore.
class Maintenance {
 public:
  explicit Maintenance(postgres::Pool& pool) : pool_(pool) {}

  // Rows of deleted sessions.
  absl::StatusOr<std::int64_t> PurgeDeletedSessions(const CallContext& context, std::int64_t limit) const;
  // Records past their site's retention, counted from the session's finish. Sessions that are recording or waiting to
  // be mapped keep theirs.
  absl::StatusOr<std::int64_t> DeleteExpiredRecords(const CallContext& context, std::int64_t limit) const;
  // Blobs that nothing refers to and that were last put longer than `grace` ago (the time that a client may take from
  // sending a blob to sending the record that refers to it).
  absl::StatusOr<std::int64_t> CollectBlobs(const CallContext& context, std::chrono::seconds grace,
                                            std::int64_t limit) const;

 private:
  postgres::Pool& pool_;
};

}  // namespace enfilade::storage
