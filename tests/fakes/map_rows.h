// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "absl/status/statusor.h"
#include "tests/fakes/in_memory_database.h"

namespace enfilade::testing {

// Where the id of a map leads to, and T_to_from. The map itself if it is no redirect, or does not exist.
rearrange::MapRedirect ResolveMap(const SiteRows& site, const MapId& map);
// Puts a layer on top of the map's.
void AddTopLayer(MapRow& row, const std::optional<SessionId>& session, const storage::StoredRaster& raster);
// As AddRevision, but the layers stay.
absl::StatusOr<std::int64_t> StoreRevision(InMemoryDatabase::Access& access, const SiteId& site, const MapId& map,
                                           const storage::NewRevision& revision,
                                           absl::Span<const storage::BlobView> blobs);

// RevisionStore::Add: the number of the new revision, or of the current one if that has the same content. Changes
// nothing unless it succeeds; the map's state is up to the caller.
absl::StatusOr<std::int64_t> AddRevision(InMemoryDatabase::Access& access, const SiteId& site, const MapId& map,
                                         const storage::NewRevision& revision,
                                         absl::Span<const storage::BlobView> blobs);

}  // namespace enfilade::testing
