// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/ids.h"
#include "core/rearrange/rearrangement.h"
#include "storage/graph/rearrangement_store.h"
#include "storage/postgres/driver/transaction.h"

namespace enfilade::storage::postgres {

// Cuts sessions within a rearrangement whose parts are stored and checked. Each rest becomes a session of its own with
// its records, keyframes, submaps (one with keyframes on both sides is in both), trajectory, verdicts, and loop
// closures (those across the cut are dropped). Sequences and ids of rows stay. Queued only.
void QueueCuts(Transaction& transaction, const SiteId& site, const RearrangementChange& change);
// Takes the rests back, before the images are restored. Their sessions count as deleted. Queued only.
void QueueUncuts(Transaction& transaction, const SiteId& site, const rearrange::RearrangementId& id);

}  // namespace enfilade::storage::postgres
