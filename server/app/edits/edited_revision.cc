// SPDX-License-Identifier: Apache-2.0
#include "server/app/edits/edited_revision.h"

#include <utility>
#include <vector>

#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "core/edit/apply.h"
#include "core/edit/history.h"
#include "core/grid/raster_header.h"
#include "server/app/mapping/layer_overlay.h"

namespace enfilade::server {

absl::StatusOr<edit::Overlay> ReadOverlay(const storage::CallContext& context, const storage::BlobStore& blobs,
                                          const SiteId& site, const storage::StoredOverlay& stored) {
  edit::Overlay overlay;
  for (const storage::TileRef& tile : stored.tiles) {
    ENFILADE_ASSIGN_OR_RETURN(const std::string bytes, blobs.Get(context, site, tile.sha256));
    ENFILADE_ASSIGN_OR_RETURN(edit::TileCells cells, edit::UnpackTile(bytes));
    overlay.Set({tile.key.row, tile.key.column}, std::move(cells));
  }
  return overlay;
}

absl::StatusOr<storage::StoredOverlay> PutOverlay(const storage::CallContext& context, const storage::BlobStore& blobs,
                                                  const SiteId& site, const edit::Lattice& lattice,
                                                  const edit::Overlay& overlay) {
  RasterRevision tiles;  // only its tiles are used
  for (const auto& [index, cells] : overlay.tiles()) {
    std::string bytes = edit::Pack(cells);
    std::string sha256 = Sha256(bytes);
    tiles.tiles.push_back({{index.row, index.column}, std::move(sha256), std::move(bytes)});
  }
  ENFILADE_RETURN_IF_ERROR(PutTiles(context, blobs, site, tiles, {}));
  storage::StoredOverlay stored;
  stored.lattice = lattice;
  for (storage::Tile& tile : tiles.tiles) stored.tiles.push_back({tile.key, std::move(tile.sha256)});
  return stored;
}

absl::StatusOr<edit::Overlay> DrawOverlay(const storage::CallContext& context, const storage::RevisionStore& revisions,
                                          const EditedMap& map, const storage::StoredOverlay& overlay,
                                          std::int64_t up_to, const edit::Lattice& lattice) {
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<edit::Publication> publications,
                            revisions.ReadPublications(context, map.site, map.map, overlay.first_version - 1, up_to));
  return edit::OverlayOf(publications, lattice);
}

absl::StatusOr<grid::MapRaster> ReadEvidence(const storage::CallContext& context, const RasterStores& stores,
                                             const storage::MapRevision& newest) {
  if (newest.edit_version == 0) return ReadRaster(context, stores.revisions, newest);
  ENFILADE_ASSIGN_OR_RETURN(const auto evidence, stores.revisions.ReadEvidence(context, newest.site, newest.map));
  if (evidence) return ReadRaster(context, stores.blobs, newest.site, *evidence);
  // An import has put an end to the edits meanwhile: what it shows, not what they did.
  ENFILADE_ASSIGN_OR_RETURN(const storage::MapRevision now, stores.revisions.Get(context, newest.site, newest.map, 0));
  if (now.number == newest.number) return ReadRaster(context, stores.revisions, newest);
  return ReadEvidence(context, stores, now);
}

absl::StatusOr<RasterRevision> StoreEdited(const storage::CallContext& context, const RasterStores& stores,
                                           const EditedMap& map, const std::optional<storage::StoredOverlay>& overlay,
                                           grid::MapRaster raster, const std::set<std::string>& known) {
  ENFILADE_ASSIGN_OR_RETURN(RasterRevision evidence, ToRevision(raster));
  ENFILADE_RETURN_IF_ERROR(PutTiles(context, stores.blobs, map.site, evidence, known));
  if (!overlay) return evidence;
  ENFILADE_ASSIGN_OR_RETURN(const grid::RasterHeader header, grid::DecodeRasterHeader(evidence.revision.raster_header));
  const edit::Lattice lattice = edit::LatticeOf(header);
  storage::StoredOverlay stored = *overlay;
  edit::Overlay instructions;
  if (lattice == overlay->lattice) {
    ENFILADE_ASSIGN_OR_RETURN(instructions, ReadOverlay(context, stores.blobs, map.site, stored));
  } else {
    ENFILADE_ASSIGN_OR_RETURN(instructions,
                              DrawOverlay(context, stores.revisions, map, *overlay, overlay->edit_version, lattice));
    ENFILADE_ASSIGN_OR_RETURN(stored, PutOverlay(context, stores.blobs, map.site, lattice, instructions));
    stored.edit_version = overlay->edit_version;
    stored.first_version = overlay->first_version;
  }
  ENFILADE_RETURN_IF_ERROR(edit::Apply(instructions, header.lattice_min, raster));
  ENFILADE_ASSIGN_OR_RETURN(RasterRevision edited, ToRevision(raster));
  std::set<std::string> present = known;
  for (const storage::TileRef& tile : evidence.revision.tiles) present.insert(tile.sha256);
  ENFILADE_RETURN_IF_ERROR(PutTiles(context, stores.blobs, map.site, edited, present));
  edited.revision.edits =
      storage::RevisionEdits{std::move(stored), {evidence.revision.raster_header, std::move(evidence.revision.tiles)}};
  return edited;
}

}  // namespace enfilade::server
