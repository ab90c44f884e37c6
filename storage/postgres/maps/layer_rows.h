// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "absl/status/status.h"
#include "core/base/ids.h"
#include "storage/postgres/driver/transaction.h"
#include "storage/revision_store.h"

namespace enfilade::storage::postgres {

// Within a transaction that has locked the map's row. Where the revision was laid together from layers that have
// changed since: ABORTED, see AreLayersChanged.
absl::Status CheckLayers(Transaction& transaction, const SiteId& site, const MapId& map, const NewRevision& revision);

// Queues what makes the revision `number` the map's only layer (an import), or stores its session's layer.
void QueueLayer(Transaction& transaction, const SiteId& site, const MapId& map, const NewRevision& revision,
                std::int64_t number);

}  // namespace enfilade::storage::postgres
