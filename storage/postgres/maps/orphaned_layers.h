// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "storage/maps/revision_store.h"
#include "storage/postgres/driver/pool.h"
#include "storage/postgres/driver/transaction.h"
#include "storage/postgres/maps/map_key.h"

namespace enfilade::storage::postgres {

// As RevisionStore::ReadOrphanedLayers.
absl::StatusOr<OrphanedLayers> ReadOrphanedLayers(Pool& pool, const CallContext& context, const MapKey& key, int least,
                                                  int limit);

// As RevisionStore::MergeLayers. Partly queued, as AddRevision.
absl::Status StoreMergedLayers(Transaction& transaction, const MapKey& key, const NewLayerRun& merged);

}  // namespace enfilade::storage::postgres
