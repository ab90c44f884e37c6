// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "absl/status/status.h"
#include "core/base/ids.h"
#include "storage/graph/site_lease_store.h"
#include "storage/postgres/driver/transaction.h"

namespace enfilade::storage::postgres {

// What every change that was decided by a site's graph starts with: locks in the order site's graph, lease.

// Locks the site's graph. ABORTED unless it is at `version`.
absl::Status LockGraphAt(Transaction& transaction, const SiteId& site, std::int64_t version);
// Keeps the lease from passing to another holder. ABORTED if it has.
absl::Status LockSiteLease(Transaction& transaction, const SiteLease& lease);

}  // namespace enfilade::storage::postgres
