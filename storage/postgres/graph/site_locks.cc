// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/graph/site_locks.h"

#include "core/base/resource_name.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/graph/graph_versions.h"

namespace enfilade::storage::postgres {
namespace {

constexpr Statement kLockSiteLease{"locking the site's lease",
                                   "SELECT token FROM enfilade.site_leases WHERE site_id = $1 FOR SHARE"};

}  // namespace

absl::Status LockGraphAt(Transaction& transaction, const SiteId& site, std::int64_t version) {
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t present, LockGraph(transaction, site));
  if (present == version) return absl::OkStatus();
  return Aborted("the graph of {} is at version {}, no longer at {}: decide again", NameOf(site), present, version);
}

absl::Status LockSiteLease(Transaction& transaction, const SiteLease& lease) {
  ENFILADE_ASSIGN_OR_RETURN(const auto locked, transaction.Execute(kLockSiteLease, Params(lease.site)));
  if (locked.rows() > 0) {
    Row row(locked, 0);
    if (row.Int64() == lease.token) return absl::OkStatus();
  }
  return Aborted("{} has lost the lease on {}", lease.owner, NameOf(lease.site));
}

}  // namespace enfilade::storage::postgres
