// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/sessions/session_leases.h"

#include <utility>

#include "core/base/resource_name.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/sessions/session_row.h"

namespace enfilade::storage::postgres {
namespace {

// Besides Maintenance and DoorVerdictStore::FindPending the only read over all sites. The work it finds is then taken
// within its site.
constexpr Statement kFindWork{"looking for sessions to map",
                              "SELECT s.site_id, s.session_id FROM enfilade.sessions s"
                              " LEFT JOIN enfilade.mapping_checkpoints c USING (site_id, session_id)"
                              " LEFT JOIN enfilade.session_leases l USING (site_id, session_id)"
                              " WHERE s.map_id IS NOT NULL AND s.state IN (1, 2)"
                              " AND (s.state = 2 OR s.acknowledged_sequence > coalesce(c.mapped_sequence, 0))"
                              " AND (l.expires_at IS NULL OR l.expires_at <= clock_timestamp())"
                              " ORDER BY l.expires_at NULLS FIRST, s.create_time LIMIT 8"};
constexpr Statement kTakeSessionLease{
    "taking the lease",
    "INSERT INTO enfilade.session_leases AS l (site_id, session_id, owner, token, attempts, expires_at)"
    " VALUES ($1, $2, $3, 1, 1, clock_timestamp() + $4 * interval '1 millisecond')"
    " ON CONFLICT (site_id, session_id) DO UPDATE SET owner = EXCLUDED.owner, token = l.token + 1,"
    " attempts = l.attempts + 1, expires_at = EXCLUDED.expires_at"
    " WHERE l.expires_at <= EXCLUDED.expires_at - $4 * interval '1 millisecond'"
    " RETURNING token, attempts"};
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

// Unset if another worker has been faster, or the session is deleted.
absl::StatusOr<std::optional<LeasedSession>> TakeLease(Pool& pool, const CallContext& context, SessionLease lease,
                                                       std::chrono::milliseconds ttl) {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool, context));
  transaction.Queue(kTakeSessionLease, Params(lease.site, lease.session, lease.owner, std::int64_t{ttl.count()}));
  transaction.Queue(kSelectLeasedSession, Params(lease.site, lease.session));
  ENFILADE_ASSIGN_OR_RETURN(const auto results, transaction.FlushAndCommit());
  if (results[0].rows() == 0 || results[1].rows() == 0) return std::nullopt;
  LeasedSession leased;
  ENFILADE_ASSIGN_OR_RETURN(leased.session, ReadOne(results[1], ReadSession, NameOf(lease.site, lease.session)));
  Row row(results[0], 0);
  lease.token = row.Int64();
  leased.attempts = row.Int64();
  ENFILADE_RETURN_IF_ERROR(row.status());
  leased.lease = std::move(lease);
  return leased;
}

}  // namespace

absl::StatusOr<std::optional<LeasedSession>> AcquireSession(Pool& pool, const CallContext& context,
                                                            const std::string& owner, std::chrono::milliseconds ttl) {
  ENFILADE_ASSIGN_OR_RETURN(const auto result, ExecuteAlone(pool, context, kFindWork, Params()));
  ENFILADE_ASSIGN_OR_RETURN(const auto candidates, ReadRows(result, [&](Row& row) {
                              SiteId site{std::string(row.Text())};
                              return SessionLease{std::move(site), SessionId(std::string(row.Text())), owner, 0};
                            }));
  for (const SessionLease& wanted : candidates) {
    ENFILADE_ASSIGN_OR_RETURN(auto leased, TakeLease(pool, context, wanted, ttl));
    if (leased) return leased;
  }
  return std::nullopt;
}

absl::Status RenewLease(Pool& pool, const CallContext& context, const SessionLease& lease,
                        std::chrono::milliseconds ttl) {
  ENFILADE_ASSIGN_OR_RETURN(const auto renewed, ExecuteAlone(pool, context, kRenewSessionLease,
                                                             Params(lease.site, lease.session, lease.owner, lease.token,
                                                                    std::int64_t{ttl.count()})));
  return renewed.affected() > 0 ? absl::OkStatus() : LeaseLost(lease);
}

absl::Status ReleaseLease(Pool& pool, const CallContext& context, const SessionLease& lease) {
  return ExecuteAlone(pool, context, kReleaseSessionLease, Params(lease.site, lease.session, lease.owner, lease.token))
      .status();
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
