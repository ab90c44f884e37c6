// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "storage/map_store.h"
#include "storage/postgres/driver/transaction.h"
#include "storage/revision_store.h"

namespace enfilade::storage::postgres {

// RevisionStore::Add within a transaction: gives the number of the new revision, or of the current one where that has
// the same content already. The map's state becomes `state`. Partly queued: errors may come with the commit only, to be
// put through ExplainRevisionError.
absl::StatusOr<std::int64_t> AddRevision(Transaction& transaction, const SiteId& site, const MapId& map,
                                         const NewRevision& revision, absl::Span<const BlobView> blobs, MapState state);

absl::Status ExplainRevisionError(const absl::Status& status, const SiteId& site, const MapId& map);

}  // namespace enfilade::storage::postgres
