// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <set>
#include <string>

#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/edit/overlay.h"
#include "core/grid/map_raster.h"
#include "server/app/mapping/raster_revision.h"
#include "storage/call_context.h"
#include "storage/maps/blob_store.h"
#include "storage/maps/revision_store.h"

namespace enfilade::server {

// Revisions with people's edits over what robots have seen, which is called evidence here.

struct RasterStores {
  const storage::BlobStore& blobs;
  const storage::RevisionStore& revisions;
};

struct EditedMap {
  SiteId site;
  MapId map;
};

// DATA_LOSS if a tile is damaged.
absl::StatusOr<edit::Overlay> ReadOverlay(const storage::CallContext& context, const storage::BlobStore& blobs,
                                          const SiteId& site, const storage::StoredOverlay& overlay);
// Stores the overlay's tiles. The result has no versions.
absl::StatusOr<storage::StoredOverlay> PutOverlay(const storage::CallContext& context, const storage::BlobStore& blobs,
                                                  const SiteId& site, const edit::Lattice& lattice,
                                                  const edit::Overlay& overlay);
// The publications' edits on the lattice. `upto`: an edit_version.
absl::StatusOr<edit::Overlay> DrawOverlay(const storage::CallContext& context, const storage::RevisionStore& revisions,
                                          const EditedMap& map, const storage::StoredOverlay& overlay,
                                          std::int64_t up_to, const edit::Lattice& lattice);

// The newest revision without its edits; of a newer one if there is one by now. Errors as ReadRaster.
absl::StatusOr<grid::MapRaster> ReadEvidence(const storage::CallContext& context, const RasterStores& stores,
                                             const storage::MapRevision& newest);

// The revision that shows `evidence` with the overlay over it, whose tiles it stores but for those in `known`. If the
// overlay is on another lattice, its edits are drawn again. Without an overlay it is the evidence itself. Errors:
// edit::Apply.
absl::StatusOr<RasterRevision> StoreEdited(const storage::CallContext& context, const RasterStores& stores,
                                           const EditedMap& map, const std::optional<storage::StoredOverlay>& overlay,
                                           grid::MapRaster evidence, const std::set<std::string>& known);

}  // namespace enfilade::server
