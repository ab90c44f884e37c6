// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/graph/site_lease_store.h"

#include "core/base/resource_name.h"
#include "storage/postgres/driver/rows.h"

namespace enfilade::storage::postgres {
namespace {

// Leases on each right are in a table of their own.
#define ENFILADE_TAKE_LEASE(table)                                                                                    \
  Statement {                                                                                                         \
    "taking the site's lease",                                                                                        \
        "INSERT INTO enfilade." table                                                                                 \
        " AS l (site_id, owner, token, expires_at)"                                                                   \
        " VALUES ($1, $2, 1, clock_timestamp() + $3 * interval '1 millisecond')"                                      \
        " ON CONFLICT (site_id) DO UPDATE SET owner = EXCLUDED.owner, token = l.token + 1,"                           \
        " expires_at = EXCLUDED.expires_at WHERE l.expires_at <= EXCLUDED.expires_at - $3 * interval '1 millisecond'" \
        " RETURNING token"                                                                                            \
  }
#define ENFILADE_RENEW_LEASE(table)                                                        \
  Statement {                                                                              \
    "renewing the site's lease", "UPDATE enfilade." table                                  \
                                 " SET expires_at = now() + $4 * interval '1 millisecond'" \
                                 " WHERE site_id = $1 AND owner = $2 AND token = $3"       \
  }
#define ENFILADE_RELEASE_LEASE(table)                                                 \
  Statement {                                                                         \
    "releasing the site's lease", "UPDATE enfilade." table                            \
                                  " SET owner = '', expires_at = now()"               \
                                  " WHERE site_id = $1 AND owner = $2 AND token = $3" \
  }
constexpr Statement kTakeChange = ENFILADE_TAKE_LEASE("site_leases");
constexpr Statement kRenewChange = ENFILADE_RENEW_LEASE("site_leases");
constexpr Statement kReleaseChange = ENFILADE_RELEASE_LEASE("site_leases");
constexpr Statement kTakeSolve = ENFILADE_TAKE_LEASE("solver_leases");
constexpr Statement kRenewSolve = ENFILADE_RENEW_LEASE("solver_leases");
constexpr Statement kReleaseSolve = ENFILADE_RELEASE_LEASE("solver_leases");

struct LeaseStatements {
  const Statement& take;
  const Statement& renew;
  const Statement& release;
};
constexpr LeaseStatements kChangeLeases = {kTakeChange, kRenewChange, kReleaseChange};
constexpr LeaseStatements kSolverLeases = {kTakeSolve, kRenewSolve, kReleaseSolve};

const LeaseStatements& Of(SiteRight right) { return right == SiteRight::kSolve ? kSolverLeases : kChangeLeases; }

}  // namespace

absl::StatusOr<std::optional<SiteLease>> SiteLeaseStore::Acquire(const CallContext& context, const SiteId& site,
                                                                 const std::string& owner,
                                                                 std::chrono::milliseconds ttl) const {
  const auto taken = ExecuteAlone(pool_, context, Of(right_).take, Params(site, owner, std::int64_t{ttl.count()}));
  if (SqlStateOf(taken.status()) == "23503") return NotFound("{} does not exist", NameOf(site));
  ENFILADE_RETURN_IF_ERROR(taken.status());
  if (taken->rows() == 0) return std::nullopt;
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t token, ReadOne(
                                                          *taken, [](Row& row) { return row.Int64(); }, "the lease"));
  return SiteLease{site, owner, token};
}

absl::Status SiteLeaseStore::Renew(const CallContext& context, const SiteLease& lease,
                                   std::chrono::milliseconds ttl) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto renewed,
                            ExecuteAlone(pool_, context, Of(right_).renew,
                                         Params(lease.site, lease.owner, lease.token, std::int64_t{ttl.count()})));
  if (renewed.affected() > 0) return absl::OkStatus();
  return Aborted("{} has lost the lease on {}", lease.owner, NameOf(lease.site));
}

absl::Status SiteLeaseStore::Release(const CallContext& context, const SiteLease& lease) const {
  return ExecuteAlone(pool_, context, Of(right_).release, Params(lease.site, lease.owner, lease.token)).status();
}

}  // namespace enfilade::storage::postgres
