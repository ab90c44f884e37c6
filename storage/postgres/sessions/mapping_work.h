// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "storage/postgres/driver/transaction.h"
#include "storage/sessions/mapping_store.h"

namespace enfilade::storage::postgres {

// The sessions that wait to be mapped, each a row of mapping_work, so that the others need not be looked at. A session
// that IsToBeMapped has a row whenever no transaction is open: who makes it so queues it in the same transaction, with
// the session's row locked, and who removes its row has locked the session's row, too. A row may be there for nothing:
// whoever takes it removes it.

// Queues those of `sessions` that are to be mapped. A session that waits already costs a look at its row. Their rows
// must be locked by `transaction`.
void QueueMappingWork(Transaction& transaction, const SiteId& site, const std::vector<std::string_view>& sessions);
// The same for those that follow `previous` and have just got their map. Their records have waited since they began.
void QueueEnteredSessions(Transaction& transaction, const SiteId& site, const SessionId& previous);

struct WaitingSession {
  SiteId site;
  SessionId session;
};
constexpr std::size_t kMappingCandidates = 8;
// Those of all sites that nobody holds and that have waited longest for their turn: kMappingCandidates, or all.
absl::StatusOr<std::vector<WaitingSession>> FindMappingWork(Pool& pool, const CallContext& context);
// At the end of a turn under `lease`, whose row the transaction locks first: queues the statement that locks the
// session and tells whether it is still to be mapped. See MappingStore::Release.
void QueueWorkLock(Transaction& transaction, const SessionLease& lease, std::int64_t read_sequence);
// Removes the session's row of mapping_work or moves it to the end of the queue. `locked`: that statement's rows.
absl::Status ReturnMappingWork(Transaction& transaction, const SessionLease& lease, std::int64_t read_sequence,
                               const Result& locked);

absl::StatusOr<MappingBacklog> ReadMappingBacklog(Pool& pool, const CallContext& context);

}  // namespace enfilade::storage::postgres
