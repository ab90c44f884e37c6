// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "core/grid/diff/map_diff.h"
#include "storage/call_context.h"
#include "storage/maps/blob_store.h"
#include "storage/maps/pyramid_store.h"
#include "storage/maps/revision_store.h"

namespace enfilade::server {

// Makes the content of an older revision the map's newest one, which replaces all layers. Returns the map's current
// revision if it was restored from the same content last. NOT_FOUND if `older` is deleted meanwhile.
absl::StatusOr<storage::MapRevision> RestoreRevision(const storage::CallContext& context,
                                                     const storage::RevisionStore& revisions,
                                                     const storage::PyramidStore& pyramids,
                                                     const storage::MapRevision& older);

// What came and went between two revisions of a map. Reads the tiles that they share once. NOT_FOUND if one of them is
// deleted meanwhile; errors as grid::DiffTiles.
absl::StatusOr<grid::MapDiff> DiffRevisions(const storage::CallContext& context, const storage::PyramidStore& pyramids,
                                            const storage::BlobStore& blobs, const storage::MapRevision& base,
                                            const storage::MapRevision& revision, const grid::MapDiffOptions& options);

}  // namespace enfilade::server
