// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "absl/status/status.h"
#include "storage/graph/rearrangement_store.h"
#include "storage/postgres/driver/transaction.h"

namespace enfilade::storage::postgres {

// The steps of undoing a rearrangement, as rearrangement_changes.h has those of applying it.

// Locks what it changed. FAILED_PRECONDITION if it is undone already, or naming what is no longer as it left it.
absl::Status LockAndCheckUnchanged(Transaction& transaction, const SiteId& site, const StoredRearrangement& stored);
// Areas as they were before. Queued only.
void QueueAreaReturns(Transaction& transaction, const SiteId& site, const rearrange::RearrangementId& id);
// Everything as it was before. INTERNAL if it is not.
absl::Status RestoreImages(Transaction& transaction, const SiteId& site, const rearrange::RearrangementId& id,
                           std::int64_t version);

}  // namespace enfilade::storage::postgres
