// SPDX-License-Identifier: Apache-2.0
#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/status_macros.h"
#include "tests/fakes/in_memory_stores.h"

namespace enfilade::testing {

LeaseRow& InMemorySiteLeaseStore::LeaseOf(SiteRows& rows) const {
  return right_ == storage::SiteRight::kSolve ? rows.solver_lease : rows.lease;
}

absl::StatusOr<std::optional<storage::SiteLease>> InMemorySiteLeaseStore::Acquire(const storage::CallContext& context,
                                                                                  const SiteId& site,
                                                                                  const std::string& owner,
                                                                                  std::chrono::milliseconds ttl) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  ENFILADE_ASSIGN_OR_RETURN(SiteRows* const rows, access.GetSite(site));
  LeaseRow& lease = LeaseOf(*rows);
  if (lease.token > 0 && lease.expires_at > access.Now()) return std::nullopt;
  lease = {owner, lease.token + 1, access.Now() + ttl, 0};
  return storage::SiteLease{site, owner, lease.token};
}

absl::Status InMemorySiteLeaseStore::Renew(const storage::CallContext& context, const storage::SiteLease& lease,
                                           std::chrono::milliseconds ttl) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  SiteRows* const rows = access.FindSite(lease.site);
  if (rows == nullptr || LeaseOf(*rows).owner != lease.owner || LeaseOf(*rows).token != lease.token) {
    return Aborted("{} has lost the lease on {}", lease.owner, NameOf(lease.site));
  }
  LeaseOf(*rows).expires_at = access.Now() + ttl;
  return absl::OkStatus();
}

absl::Status InMemorySiteLeaseStore::Release(const storage::CallContext& context,
                                             const storage::SiteLease& lease) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  SiteRows* const rows = access.FindSite(lease.site);
  if (rows == nullptr) return absl::OkStatus();
  LeaseRow& held = LeaseOf(*rows);
  if (held.owner != lease.owner || held.token != lease.token) return absl::OkStatus();
  held.owner.clear();
  held.expires_at = access.Now();
  return absl::OkStatus();
}

}  // namespace enfilade::testing
