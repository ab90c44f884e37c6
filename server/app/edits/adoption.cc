// SPDX-License-Identifier: Apache-2.0
// The edits of maps that are merged into others.
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "core/grid/raster_header.h"
#include "server/app/edits/map_edits.h"
#include "server/app/mapping/layer_overlay.h"

namespace enfilade::server {
namespace {

// The same for the same publication, so that a map that is merged once more brings only what is new.
MapDraftId AdoptionId(const MapId& from, std::int64_t version) {
  std::string id = "m";
  for (const char c : Sha256(fmt::format("{}/{}", from.value(), version)).substr(0, 16)) {
    id += fmt::format("{:02x}", static_cast<unsigned char>(c));
  }
  return MapDraftId(std::move(id));
}

storage::AdoptedPublication Adopted(const edit::Publication& publication, const EditedMap& kept,
                                    const rearrange::MapRedirect& redirect) {
  storage::AdoptedPublication adopted;
  adopted.from = redirect.from;
  adopted.from_version = publication.edit_version;
  adopted.message = publication.message;
  adopted.draft.key = {kept.site, kept.map, AdoptionId(redirect.from, publication.edit_version)};
  adopted.draft.display_name = fmt::format("Edits of {}", NameOf(kept.site, redirect.from));
  for (const edit::KeptEdit& edit : publication.edits) {
    if (!edit.active) continue;
    adopted.draft.lattice = {edit.lattice.resolution, redirect.T_to_from * edit.lattice.T_map_lattice};
    adopted.edits.push_back({edit.id, edit.author, edit.edit});
  }
  return adopted;
}

std::vector<edit::KeptEdit> AsKept(const storage::AdoptedPublication& adopted) {
  std::vector<edit::KeptEdit> kept;
  for (const storage::NewMapEdit& edit : adopted.edits) {
    const auto sequence = static_cast<std::int64_t>(kept.size()) + 1;
    kept.push_back({edit.id, edit.author, sequence, true, adopted.draft.lattice, edit.edit});
  }
  return kept;
}

}  // namespace

absl::StatusOr<std::vector<storage::AdoptedPublication>> MapEdits::PublicationsToAdopt(
    const storage::CallContext& context, const EditedMap& kept, const rearrange::MapRedirect& redirect,
    storage::RearrangementChange& change) const {
  ENFILADE_ASSIGN_OR_RETURN(const storage::OverlayState state, edits_.ReadOverlay(context, kept.site, redirect.from));
  change.seen.push_back({redirect.from, state.layers_version});
  std::vector<storage::AdoptedPublication> all;
  if (!state.overlay) return all;
  ENFILADE_ASSIGN_OR_RETURN(
      const auto publications,
      rasters_.revisions.ReadPublications(context, kept.site, redirect.from, state.overlay->first_version - 1,
                                          state.overlay->edit_version));
  for (const edit::Publication& publication : publications) {
    storage::AdoptedPublication adopted = Adopted(publication, kept, redirect);
    if (adopted.edits.empty()) continue;
    const absl::Status known = edits_.Get(context, adopted.draft.key).status();
    if (absl::IsNotFound(known)) {
      all.push_back(std::move(adopted));
    } else {
      ENFILADE_RETURN_IF_ERROR(known);
    }
  }
  return all;
}

absl::Status MapEdits::AdoptIn(const storage::CallContext& context, const EditedMap& kept,
                               storage::RearrangedRaster& raster) const {
  ENFILADE_ASSIGN_OR_RETURN(const storage::OverlayState state, edits_.ReadOverlay(context, kept.site, kept.map));
  storage::NewRevision& revision = *raster.revision;
  const storage::StoredRaster evidence =
      revision.edits ? revision.edits->evidence : storage::StoredRaster{revision.raster_header, revision.tiles};
  ENFILADE_ASSIGN_OR_RETURN(grid::MapRaster cells, ReadRaster(context, rasters_.blobs, kept.site, evidence));
  ENFILADE_ASSIGN_OR_RETURN(const grid::RasterHeader header, grid::DecodeRasterHeader(evidence.header));
  std::int64_t version = state.overlay ? state.overlay->edit_version : 0;
  std::vector<std::vector<edit::KeptEdit>> drafts;
  for (storage::AdoptedPublication& adopted : raster.adopted) {
    adopted.draft.base_edit_version = version;
    adopted.edit_version = ++version;
    drafts.push_back(AsKept(adopted));
  }
  ENFILADE_ASSIGN_OR_RETURN(storage::NewRevision edited,
                            Lay(context, kept, state, std::move(cells), edit::LatticeOf(header), drafts));
  edited.source = revision.source;
  edited.session = revision.session;
  revision = std::move(edited);
  return absl::OkStatus();
}

absl::Status MapEdits::Adopt(const storage::CallContext& context, const SiteId& site,
                             storage::RearrangementChange& change) const {
  for (const rearrange::MapRedirect& redirect : change.rearrangement.redirects) {
    const EditedMap kept{site, redirect.to};
    ENFILADE_ASSIGN_OR_RETURN(auto adopted, PublicationsToAdopt(context, kept, redirect, change));
    for (storage::RearrangedRaster& raster : change.rasters) {
      if (raster.map != redirect.to || !raster.revision) continue;
      for (storage::AdoptedPublication& publication : adopted) raster.adopted.push_back(std::move(publication));
    }
  }
  for (storage::RearrangedRaster& raster : change.rasters) {
    if (!raster.adopted.empty()) ENFILADE_RETURN_IF_ERROR(AdoptIn(context, {site, raster.map}, raster));
  }
  return absl::OkStatus();
}

}  // namespace enfilade::server
