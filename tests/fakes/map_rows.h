// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "absl/status/statusor.h"
#include "tests/fakes/in_memory_database.h"

namespace enfilade::testing {

// RevisionStore::Add: the number of the new revision, or of the current one if that has the same content. Changes
// nothing unless it succeeds; the map's state is up to the caller.
absl::StatusOr<std::int64_t> AddRevision(InMemoryDatabase::Access& access, const SiteId& site, const MapId& map,
                                         const storage::NewRevision& revision,
                                         absl::Span<const storage::BlobView> blobs);

}  // namespace enfilade::testing
