// SPDX-License-Identifier: Apache-2.0
// The part of MappingStore that says who may map a session.
#include "core/base/resource_name.h"
#include "storage/mapping_store.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/sessions/session_row.h"

namespace enfilade::storage {
namespace {

using postgres::ExecuteAlone;
using postgres::Params;
using postgres::Row;
using postgres::Statement;
using postgres::Transaction;

// The only reads, with those of Maintenance, that go over all sites: work is found here, and taken by its site's name.
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
    "INSERT INTO enfilade.session_leases AS l (site_id, session_id, owner, token, expires_at)"
    " VALUES ($1, $2, $3, 1, clock_timestamp() + $4 * interval '1 millisecond')"
    " ON CONFLICT (site_id, session_id) DO UPDATE SET owner = EXCLUDED.owner, token = l.token + 1,"
    " expires_at = EXCLUDED.expires_at WHERE l.expires_at <= clock_timestamp() RETURNING token"};
// A statement of its own, after the lease is taken: it sees a deletion that came in between.
constexpr Statement kSelectLeasedSession{"reading the session",
                                         "SELECT " ENFILADE_SESSION_COLUMNS " FROM " ENFILADE_SESSION_TABLES
                                         " WHERE s.site_id = $1 AND s.session_id = $2 AND s.map_id IS NOT NULL"};
constexpr Statement kRenewSessionLease{"renewing the lease",
                                       "UPDATE enfilade.session_leases"
                                       " SET expires_at = clock_timestamp() + $5 * interval '1 millisecond'"
                                       " WHERE site_id = $1 AND session_id = $2 AND owner = $3 AND token = $4"};
constexpr Statement kReleaseSessionLease{"giving the lease back",
                                         "UPDATE enfilade.session_leases SET owner = '', expires_at = clock_timestamp()"
                                         " WHERE site_id = $1 AND session_id = $2 AND owner = $3 AND token = $4"};

// Unset where another has been faster, or the session is deleted.
absl::StatusOr<std::optional<LeasedSession>> Take(postgres::Pool& pool, const CallContext& context, const SiteId& site,
                                                  const SessionId& session, const std::string& owner,
                                                  std::chrono::milliseconds ttl) {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool, context));
  transaction.Queue(kTakeSessionLease, Params(site, session, owner, std::int64_t{ttl.count()}));
  transaction.Queue(kSelectLeasedSession, Params(site, session));
  ENFILADE_ASSIGN_OR_RETURN(const auto results, transaction.FlushAndCommit());
  if (results[0].rows() == 0 || results[1].rows() == 0) return std::nullopt;
  LeasedSession leased;
  ENFILADE_ASSIGN_OR_RETURN(leased.session,
                            storage::postgres::ReadOne(results[1], postgres::ReadSession, NameOf(site, session)));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t token,
                            storage::postgres::ReadOne(
                                results[0], [](Row& row) { return row.Int64(); }, "the lease"));
  leased.lease = {site, session, owner, token};
  return leased;
}

}  // namespace

absl::StatusOr<std::optional<LeasedSession>> MappingStore::Acquire(const CallContext& context, const std::string& owner,
                                                                   std::chrono::milliseconds ttl) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto result, storage::postgres::ExecuteAlone(pool_, context, kFindWork, Params()));
  ENFILADE_ASSIGN_OR_RETURN(const auto candidates, storage::postgres::ReadRows(result, [](Row& row) {
                              const std::string site(row.Text());
                              return std::pair(SiteId(site), SessionId(std::string(row.Text())));
                            }));
  for (const auto& [site, session] : candidates) {
    ENFILADE_ASSIGN_OR_RETURN(auto leased, Take(pool_, context, site, session, owner, ttl));
    if (leased) return leased;
  }
  return std::nullopt;
}

absl::Status MappingStore::Renew(const CallContext& context, const SessionLease& lease,
                                 std::chrono::milliseconds ttl) const {
  ENFILADE_ASSIGN_OR_RETURN(
      const auto renewed, storage::postgres::ExecuteAlone(
                              pool_, context, kRenewSessionLease,
                              Params(lease.site, lease.session, lease.owner, lease.token, std::int64_t{ttl.count()})));
  if (renewed.affected() > 0) return absl::OkStatus();
  return Aborted("{} has lost the lease on {}", lease.owner, NameOf(lease.site, lease.session));
}

absl::Status MappingStore::Release(const CallContext& context, const SessionLease& lease) const {
  return storage::postgres::ExecuteAlone(pool_, context, kReleaseSessionLease,
                                         Params(lease.site, lease.session, lease.owner, lease.token))
      .status();
}

}  // namespace enfilade::storage
