// SPDX-License-Identifier: Apache-2.0
// Revisions that nobody has drawn or mapped: what is below the edits has changed, or whose map it is.
#include <limits>
#include <utility>

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/sha256.h"
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

// The same for the same two maps, so that edits are adopted once.
MapDraftId AdoptionId(const MapId& kept, const MapId& merged) {
  std::string id = "m";
  for (const char c : Sha256(kept.value() + "/" + merged.value()).substr(0, 16)) {
    id += fmt::format("{:02x}", static_cast<unsigned char>(c));
  }
  return MapDraftId(std::move(id));
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

absl::Status MapEdits::Adopt(const storage::CallContext& context, const EditedMap& kept, const MapId& merged,
                             const Pose2& T_kept_merged) const {
  ENFILADE_ASSIGN_OR_RETURN(const storage::OverlayState state, edits_.ReadOverlay(context, kept.site, merged));
  if (!state.overlay || state.overlay->tiles.empty()) return absl::OkStatus();
  const storage::StoredOverlay& overlay = *state.overlay;
  ENFILADE_ASSIGN_OR_RETURN(
      const auto publications,
      rasters_.revisions.ReadPublications(context, kept.site, merged, overlay.first_version - 1, overlay.edit_version));
  storage::MapDraft draft;
  draft.key = {kept.site, kept.map, AdoptionId(kept.map, merged)};
  draft.display_name = fmt::format("Edits of {}", NameOf(kept.site, merged));
  draft.lattice = {overlay.lattice.resolution, T_kept_merged * overlay.lattice.T_map_lattice};
  std::vector<storage::NewMapEdit> edits;
  std::vector<edit::KeptEdit> drawn;
  for (const edit::Publication& publication : publications) {
    for (const edit::KeptEdit& of_merged : publication.edits) {
      edit::MapEdit edit = of_merged.edit;
      edit.shape = edit::OnLattice(edit.shape, of_merged.lattice, overlay.lattice);
      const auto number = static_cast<std::int64_t>(edits.size()) + 1;
      edits.push_back({fmt::format("{}", number), of_merged.author, edit});
      drawn.push_back({edits.back().id, of_merged.author, number, true, draft.lattice, std::move(edit)});
    }
  }
  const std::string message = fmt::format("edits of {}, which was merged into this map", NameOf(kept.site, merged));
  absl::Status status;
  for (int attempt = 0; attempt < kMaxRecompositions; ++attempt) {
    storage::NewPublication publication{0, 0, message, {}};
    ENFILADE_ASSIGN_OR_RETURN(publication.revision, Compose(context, kept, drawn));
    draft.base_edit_version = publication.revision.edits->overlay.edit_version - 1;
    status = edits_.PublishAtOnce(context, draft, edits, publication).status();
    if (absl::IsAlreadyExists(status)) return absl::OkStatus();
    if (!storage::AreLayersChanged(status)) return status;
  }
  return status;
}

}  // namespace enfilade::server
