// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/sessions/session_leases.h"

#include <vector>

#include "core/base/resource_name.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/sessions/mapping_work.h"
#include "storage/postgres/sessions/session_row.h"

namespace enfilade::storage::postgres {
namespace {

constexpr Statement kTakeSessionLease{
    "taking the lease",
    "INSERT INTO enfilade.session_leases AS l (site_id, session_id, owner, token, attempts, expires_at)"
    " VALUES ($1, $2, $3, 1, 1, clock_timestamp() + $4 * interval '1 millisecond')"
    " ON CONFLICT (site_id, session_id) DO UPDATE SET owner = EXCLUDED.owner, token = l.token + 1,"
    " attempts = l.attempts + 1, expires_at = EXCLUDED.expires_at"
    " WHERE l.expires_at <= EXCLUDED.expires_at - $4 * interval '1 millisecond'"
    " RETURNING token, attempts, expires_at - $4 * interval '1 millisecond'"};
// A separate statement after the lease is taken: it sees a deletion that came in between.
constexpr Statement kSelectLeasedSession{"reading the session",
                                         "SELECT " ENFILADE_SESSION_COLUMNS " FROM " ENFILADE_SESSION_TABLES
                                         " WHERE s.site_id = $1 AND s.session_id = $2 AND s.map_id IS NOT NULL"};
constexpr Statement kRenewSessionLease{"renewing the lease",
                                       "UPDATE enfilade.session_leases"
                                       " SET expires_at = now() + $5 * interval '1 millisecond'"
                                       " WHERE site_id = $1 AND session_id = $2 AND owner = $3 AND token = $4"};
constexpr Statement kReleaseSessionLease{"releasing the lease",
                                         "UPDATE enfilade.session_leases"
                                         " SET owner = '', attempts = 0, expires_at = now()"
                                         " WHERE site_id = $1 AND session_id = $2 AND owner = $3 AND token = $4"};

// Blocks others from taking the lease and from deleting the session.
constexpr Statement kLockSessionLease{"locking the lease",
                                      "SELECT token FROM enfilade.session_leases"
                                      " WHERE site_id = $1 AND session_id = $2 FOR UPDATE"};
// A separate statement: it sees a deletion that the lock has waited for.
constexpr Statement kSelectMappedSession{
    "reading the session",
    "SELECT s.map_id, s.state, coalesce(c.mapped_sequence, 0) FROM enfilade.sessions s"
    " LEFT JOIN enfilade.mapping_checkpoints c USING (site_id, session_id)"
    " WHERE s.site_id = $1 AND s.session_id = $2 AND s.delete_time IS NULL AND s.map_id IS NOT NULL"};
HeldSession ReadHeldSession(Row& row) {
  HeldSession session;
  session.map = MapId(std::string(row.Text()));
  session.progress.state = static_cast<SessionState>(row.Int16());
  session.progress.mapped_sequence = row.Int64();
  return session;
}

struct TakenLease {
  std::int64_t token = 0;
  std::int64_t attempts = 0;
  TimeNs time = 0;
};
TakenLease ReadTakenLease(Row& row) {
  TakenLease taken;
  taken.token = row.Int64();
  taken.attempts = row.Int64();
  taken.time = row.Time();
  return taken;
}

// Unset if another worker has been faster, or there is nothing to map after all, which is noted.
absl::StatusOr<std::optional<LeasedSession>> TakeLease(Pool& pool, const CallContext& context,
                                                       const WaitingSession& waiting, const std::string& owner,
                                                       std::chrono::milliseconds ttl) {
  std::vector<Result> results;
  {  // the connection is free again before ReleaseLease takes one
    ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool, context));
    transaction.Queue(kTakeSessionLease, Params(waiting.site, waiting.session, owner, std::int64_t{ttl.count()}));
    transaction.Queue(kSelectLeasedSession, Params(waiting.site, waiting.session));
    ENFILADE_ASSIGN_OR_RETURN(results, transaction.FlushAndCommit());
  }
  if (results[0].rows() == 0) return std::nullopt;
  const std::string name = NameOf(waiting.site, waiting.session);
  ENFILADE_ASSIGN_OR_RETURN(const TakenLease taken, ReadOne(results[0], ReadTakenLease, name));
  LeasedSession leased;
  if (results[1].rows() > 0) {
    ENFILADE_ASSIGN_OR_RETURN(leased.session, ReadOne(results[1], ReadSession, name));
  }
  leased.attempts = taken.attempts;
  leased.lease = {waiting.site, waiting.session, owner, taken.token, taken.time, leased.session.acknowledged_sequence};
  if (IsToBeMapped(leased.session, 0)) return leased;
  ENFILADE_RETURN_IF_ERROR(ReleaseLease(pool, context, leased.lease, 0));
  return std::nullopt;
}

}  // namespace

absl::StatusOr<std::optional<LeasedSession>> AcquireSession(Pool& pool, const CallContext& context,
                                                            const std::string& owner, std::chrono::milliseconds ttl) {
  std::vector<WaitingSession> candidates;
  do {  // what is not taken now is held or no longer waits
    ENFILADE_ASSIGN_OR_RETURN(candidates, FindMappingWork(pool, context));
    for (const WaitingSession& waiting : candidates) {
      ENFILADE_ASSIGN_OR_RETURN(auto leased, TakeLease(pool, context, waiting, owner, ttl));
      if (leased) return leased;
    }
  } while (candidates.size() == kMappingCandidates);
  return std::nullopt;
}

absl::Status RenewLease(Pool& pool, const CallContext& context, const SessionLease& lease,
                        std::chrono::milliseconds ttl) {
  ENFILADE_ASSIGN_OR_RETURN(const auto renewed, ExecuteAlone(pool, context, kRenewSessionLease,
                                                             Params(lease.site, lease.session, lease.owner, lease.token,
                                                                    std::int64_t{ttl.count()})));
  return renewed.affected() > 0 ? absl::OkStatus() : LeaseLost(lease);
}

absl::Status ReleaseLease(Pool& pool, const CallContext& context, const SessionLease& lease,
                          std::int64_t read_sequence) {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool, context));
  transaction.Queue(kReleaseSessionLease, Params(lease.site, lease.session, lease.owner, lease.token));
  QueueWorkLock(transaction, lease, read_sequence);
  ENFILADE_ASSIGN_OR_RETURN(const auto results, transaction.Flush());
  if (results[0].affected() == 0) return absl::OkStatus();
  ENFILADE_RETURN_IF_ERROR(ReturnMappingWork(transaction, lease, read_sequence, results[1]));
  return transaction.Commit();
}

absl::StatusOr<HeldSession> LockLease(Transaction& transaction, const SessionLease& lease) {
  transaction.Queue(kLockSessionLease, Params(lease.site, lease.session));
  transaction.Queue(kSelectMappedSession, Params(lease.site, lease.session));
  ENFILADE_ASSIGN_OR_RETURN(const auto results, transaction.Flush());
  if (results[0].rows() == 0 || results[1].rows() == 0) return LeaseLost(lease);
  Row row(results[0], 0);
  if (row.Int64() != lease.token) return LeaseLost(lease);
  return ReadOne(results[1], ReadHeldSession, NameOf(lease.site, lease.session));
}

}  // namespace enfilade::storage::postgres
