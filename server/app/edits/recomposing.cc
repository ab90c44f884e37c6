// SPDX-License-Identifier: Apache-2.0
// Revisions that nobody has drawn or mapped: what is below the edits has changed.
#include <limits>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "server/app/edits/map_edits.h"
#include "server/app/mapping/layer_overlay.h"

namespace enfilade::server {
namespace {

// Limits how often a revision is composed again because robots map meanwhile.
constexpr int kMaxRecompositions = 100;

// The layers as one raster. An import that nobody has mapped in keeps its form.
absl::StatusOr<grid::MapRaster> EvidenceOf(const storage::CallContext& context, const RasterStores& stores,
                                           const SiteId& site, const storage::LayersBeside& layers, double resolution) {
  if (layers.below.size() == 1 && !layers.below[0].session) {
    return ReadRaster(context, stores.blobs, site, layers.below[0].raster);
  }
  grid::OccupancyGrid none;
  none.geometry.resolution = resolution;
  LayerOverlay overlay(stores.blobs, site);
  ENFILADE_ASSIGN_OR_RETURN(grid::OccupancyGrid grid, overlay.Compose(context, layers, none));
  return grid::FromOccupancyGrid(std::move(grid));
}

}  // namespace

absl::Status MapEdits::Recompose(const storage::CallContext& context, const EditedMap& map) const {
  absl::Status status;
  for (int attempt = 0; attempt < kMaxRecompositions; ++attempt) {
    ENFILADE_ASSIGN_OR_RETURN(const storage::LayersBeside layers,
                              rasters_.revisions.ReadLayersBeside(context, map.site, map.map, SessionId()));
    if (layers.below.empty()) return absl::OkStatus();
    ENFILADE_ASSIGN_OR_RETURN(const storage::MapRevision newest, rasters_.revisions.Get(context, map.site, map.map, 0));
    ENFILADE_ASSIGN_OR_RETURN(grid::MapRaster evidence,
                              EvidenceOf(context, rasters_, map.site, layers, newest.geometry.resolution));
    ENFILADE_ASSIGN_OR_RETURN(RasterRevision whole,
                              StoreEdited(context, rasters_, map, layers.edits, std::move(evidence), {}));
    const bool is_same = whole.revision.content_sha256 == newest.content_sha256 && !whole.revision.edits;
    if (is_same) return absl::OkStatus();
    whole.revision.source = storage::RevisionSource::kEdit;
    whole.revision.layers_version = layers.version;
    status = edits_.StoreRecomposed(context, map.site, map.map, whole.revision);
    if (!storage::AreLayersChanged(status)) return status;
  }
  return status;
}

}  // namespace enfilade::server
