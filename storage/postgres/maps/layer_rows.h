// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "storage/maps/revision_store.h"
#include "storage/postgres/driver/transaction.h"
#include "storage/postgres/maps/map_key.h"

namespace enfilade::storage::postgres {

// As RevisionStore::ReadRunsBeside, and as ReadLayersBeside without a resolution.
absl::StatusOr<LayersBeside> ReadLayers(Pool& pool, const CallContext& context, const MapKey& key,
                                        const SessionId& session, std::optional<double> resolution);

// LayersBeside::version.
absl::StatusOr<std::int64_t> ReadLayersVersion(Pool& pool, const CallContext& context, const MapKey& key);

// LayersChanged if they are no longer those of `version`.
absl::Status LockLayers(Transaction& transaction, const MapKey& key, std::int64_t version);

// As RevisionStore::AddRun. Partly queued, as AddRevision.
absl::Status StoreRun(Transaction& transaction, const MapKey& key, const NewLayerRun& run);

// Within a transaction that has locked the map's row. LayersChanged if they are no longer those of `version`.
absl::Status CheckLayers(Transaction& transaction, const MapKey& key, std::int64_t version);

// Raises the version of the layers only: what lies over them has changed. Queued only.
void QueueLayersVersion(Transaction& transaction, const MapKey& key);

// Whoever changes or deletes layers otherwise calls this first: raises their version, and forgets the map's runs.
// Queued only.
void QueueLayersChange(Transaction& transaction, const MapKey& key);

// Makes the revision `number` the map's only layer (ReplacesLayers), or stores its session's layer. Queued only.
void QueueLayer(Transaction& transaction, const MapKey& key, const NewRevision& revision, std::int64_t number);

// Puts a layer on top of the map's. `session`: unset if it was imported. Queued only.
void QueueTopLayer(Transaction& transaction, const MapKey& key, const std::optional<SessionId>& session,
                   const StoredRaster& raster);

}  // namespace enfilade::storage::postgres
