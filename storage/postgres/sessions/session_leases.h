// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "storage/postgres/driver/transaction.h"
#include "storage/sessions/mapping_store.h"

namespace enfilade::storage::postgres {

// The leases of MappingStore.
absl::StatusOr<std::optional<LeasedSession>> AcquireSession(Pool& pool, const CallContext& context,
                                                            const std::string& owner, std::chrono::milliseconds ttl);
absl::Status RenewLease(Pool& pool, const CallContext& context, const SessionLease& lease,
                        std::chrono::milliseconds ttl);
absl::Status ReleaseLease(Pool& pool, const CallContext& context, const SessionLease& lease,
                          std::int64_t read_sequence);

// The session of a lease that the transaction holds until it ends: nobody can take the lease or delete the session.
struct HeldSession {
  MapId map;
  MappingProgress progress;
};
// ABORTED if the lease is lost.
absl::StatusOr<HeldSession> LockLease(Transaction& transaction, const SessionLease& lease);

}  // namespace enfilade::storage::postgres
