// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "storage/maps/map_store.h"
#include "storage/maps/revision_store.h"
#include "storage/postgres/driver/transaction.h"
#include "storage/postgres/maps/map_key.h"

namespace enfilade::storage::postgres {

// RevisionStore::Add within a transaction. Returns the number of the new revision, or of the current one if that has
// the same content. The map's state becomes `state`. Partly queued: errors may not appear before the commit. Pass them
// to ExplainRevisionError.
absl::StatusOr<std::int64_t> AddRevision(Transaction& transaction, const MapKey& key, const NewRevision& revision,
                                         absl::Span<const BlobView> blobs, MapState state);
// The same without its layer, which the caller stores.
absl::StatusOr<std::int64_t> StoreRevision(Transaction& transaction, const MapKey& key, const NewRevision& revision,
                                           absl::Span<const BlobView> blobs, MapState state);

// Has the map's revisions looked at by their retention: there is a new one, or one has lost its tag or alias.
void QueueRevisionReview(Transaction& transaction, const MapKey& key);

// An error of the schema in terms of the API.
absl::Status ExplainRevisionError(const absl::Status& status, const SiteId& site, const MapId& map);

}  // namespace enfilade::storage::postgres
