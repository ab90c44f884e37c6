// SPDX-License-Identifier: Apache-2.0
// How drafts become revisions, and what becomes of contested edits.
#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/status_macros.h"
#include "core/base/uuid.h"
#include "core/edit/apply.h"
#include "core/edit/patches.h"
#include "server/app/edits/map_edits.h"
#include "server/app/mapping/layer_overlay.h"

namespace enfilade::server {
namespace {

// Limits how often a revision is composed again because robots map meanwhile.
constexpr int kMaxPublishAttempts = 100;

using edit::Instruction;

std::string NameOfMap(const EditedMap& map) { return NameOf(map.site, map.map); }

absl::Status RefuseProblems(const DraftCheck& check, bool confirm_warnings) {
  for (const DraftProblem& problem : check.problems) {
    if (problem.is_error) return FailedPrecondition("{}", problem.message);
    if (!confirm_warnings) {
      return FailedPrecondition("{}; set confirm_warnings to publish all the same", problem.message);
    }
  }
  return absl::OkStatus();
}

absl::Status RefuseConflicts(const DraftCheck& check, const storage::MapDraft& draft) {
  if (check.conflicts.empty()) return absl::OkStatus();
  const edit::CellBox& box = check.conflicts[0].region.box;
  return Aborted(
      "{} and publication {} say different things at {} places, the first of them {} x {} cells from"
      " ({}, {}): settle them by RebaseMapDraft",
      NameOf(draft.key.site, draft.key.map, draft.key.draft), check.edit_version, check.conflicts.size(), box.width,
      box.height, box.first_column, box.first_row);
}

bool Covers(const edit::CellBox& outer, const edit::CellBox& inner) {
  return inner.first_column >= outer.first_column && inner.first_row >= outer.first_row &&
         inner.end_column() <= outer.end_column() && inner.end_row() <= outer.end_row();
}

// The smallest that covers the box: boxes of regions may lie in one another. Null: none.
const ConflictResolution* ResolutionOf(const edit::CellBox& box, absl::Span<const ConflictResolution> resolutions) {
  const auto size = [](const edit::CellBox& one) { return std::int64_t{one.width} * one.height; };
  const ConflictResolution* best = nullptr;
  for (const ConflictResolution& resolution : resolutions) {
    if (!Covers(resolution.box, box)) continue;
    if (best == nullptr || size(resolution.box) < size(best->box)) best = &resolution;
  }
  return best;
}

// What a session's layer shows surely, on the lattice of the map's edits.
absl::StatusOr<edit::Witness> WitnessOf(const storage::CallContext& context, const RasterStores& stores,
                                        const EditedMap& map, const storage::LayerWitness& layer,
                                        const edit::Lattice& lattice) {
  ENFILADE_ASSIGN_OR_RETURN(const grid::MapRaster raster, ReadRaster(context, stores.blobs, map.site, layer.raster));
  ENFILADE_ASSIGN_OR_RETURN(const grid::RasterHeader header, grid::DecodeRasterHeader(layer.raster.header));
  edit::Witness witness;
  if (edit::LatticeOf(header) != lattice) return witness;  // of another resolution: it cannot contest cells of this one
  witness.box = edit::BoxOf(header);
  witness.classes = edit::ClassesOf(raster);
  witness.edit_version = layer.edit_version;
  return witness;
}

}  // namespace

absl::StatusOr<edit::Overlay> MapEdits::OverlayOn(const storage::CallContext& context, const EditedMap& map,
                                                  const storage::StoredOverlay& published,
                                                  const edit::Lattice& lattice) const {
  if (published.lattice == lattice) return ReadOverlay(context, rasters_.blobs, map.site, published);
  return DrawOverlay(context, rasters_.revisions, map, published, published.edit_version, lattice);
}

absl::StatusOr<storage::NewRevision> MapEdits::Compose(const storage::CallContext& context, const EditedMap& map,
                                                       const std::vector<edit::KeptEdit>& edits) const {
  // First what the map is: if it changes after this, what is composed is refused, and composed again.
  ENFILADE_ASSIGN_OR_RETURN(const storage::OverlayState state, edits_.ReadOverlay(context, map.site, map.map));
  ENFILADE_ASSIGN_OR_RETURN(const storage::MapRevision newest, rasters_.revisions.Get(context, map.site, map.map, 0));
  absl::StatusOr<grid::MapRaster> evidence = state.evidence
                                                 ? ReadRaster(context, rasters_.blobs, map.site, *state.evidence)
                                                 : ReadRaster(context, rasters_.revisions, newest);
  ENFILADE_RETURN_IF_ERROR(evidence.status());
  ENFILADE_ASSIGN_OR_RETURN(const grid::RasterHeader header,
                            grid::DecodeRasterHeader(state.evidence ? state.evidence->header : newest.raster_header));
  ENFILADE_ASSIGN_OR_RETURN(
      storage::NewRevision revision,
      Lay(context, map, state, *std::move(evidence), edit::LatticeOf(header), absl::MakeConstSpan(&edits, 1)));
  revision.source = storage::RevisionSource::kEdit;
  revision.layers_version = state.layers_version;
  return revision;
}

absl::StatusOr<storage::NewRevision> MapEdits::Lay(const storage::CallContext& context, const EditedMap& map,
                                                   const storage::OverlayState& state, grid::MapRaster evidence,
                                                   const edit::Lattice& lattice,
                                                   absl::Span<const std::vector<edit::KeptEdit>> drafts) const {
  const storage::StoredOverlay published = state.overlay.value_or(storage::StoredOverlay{});
  edit::Overlay overlay;
  if (state.overlay) {
    ENFILADE_ASSIGN_OR_RETURN(overlay, OverlayOn(context, map, published, lattice));
  }
  for (const std::vector<edit::KeptEdit>& edits : drafts) {
    overlay = edit::Combine(overlay, edit::LayerOf(edits, lattice));
  }
  ENFILADE_ASSIGN_OR_RETURN(storage::StoredOverlay stored,
                            PutOverlay(context, rasters_.blobs, map.site, lattice, overlay));
  stored.edit_version = published.edit_version + static_cast<std::int64_t>(drafts.size());
  stored.first_version = published.first_version;
  ENFILADE_ASSIGN_OR_RETURN(RasterRevision whole, StoreEdited(context, rasters_, map, stored, std::move(evidence), {}));
  return std::move(whole.revision);
}

absl::StatusOr<PublishedDraft> MapEdits::Publish(const storage::CallContext& context, const storage::MapDraftKey& key,
                                                 const PublishRequest& request) {
  const std::shared_ptr<SharedView> shared = ViewOf(key);
  const MutexLock lock(shared->mutex);
  DraftView& view = shared->view;
  absl::StatusOr<storage::MapDraft> published = Aborted("{} keeps changing", NameOf(key.site, key.map));
  for (int attempt = 0; attempt < kMaxPublishAttempts; ++attempt) {
    ENFILADE_RETURN_IF_ERROR(view.Update(context));
    const storage::MapDraft draft = view.draft();
    // Whoever sends the same request again, because the answer did not arrive, gets it now.
    if (draft.published && draft.published->message == request.message) return PublishedDraft{draft, {}, 0};
    ENFILADE_ASSIGN_OR_RETURN(const DraftCheck check, CheckView(context, view));
    ENFILADE_RETURN_IF_ERROR(RefuseConflicts(check, draft));
    ENFILADE_RETURN_IF_ERROR(RefuseProblems(check, request.confirm_warnings));
    storage::NewPublication publication{request.etag, request.expected_head, request.message, {}};
    // Not another draft that has been made under its name meanwhile.
    if (publication.etag == 0 && publication.expected_head == 0) publication.etag = draft.etag;
    if (publication.expected_head == 0) publication.expected_head = draft.head;
    ENFILADE_ASSIGN_OR_RETURN(publication.revision, Compose(context, {key.site, key.map}, view.KeptEdits()));
    // Others have published since the check.
    if (publication.revision.edits->overlay.edit_version != check.edit_version + 1) continue;
    published = edits_.Publish(context, key, publication);
    if (published.ok()) {
      return PublishedDraft{*published, check.changes, check.edit_version - draft.base_edit_version};
    }
    const bool is_edited = absl::IsAborted(published.status()) && request.expected_head == 0 && request.etag == 0;
    if (!storage::AreLayersChanged(published.status()) && !is_edited) return published.status();
  }
  return published.status();
}

absl::StatusOr<storage::MapDraft> MapEdits::Rebase(const storage::CallContext& context, const storage::MapDraftKey& key,
                                                   std::int64_t edit_version,
                                                   absl::Span<const ConflictResolution> resolutions,
                                                   const std::string& author) {
  const std::shared_ptr<SharedView> shared = ViewOf(key);
  const MutexLock lock(shared->mutex);
  DraftView& view = shared->view;
  ENFILADE_RETURN_IF_ERROR(view.Update(context));
  ENFILADE_ASSIGN_OR_RETURN(const DraftCheck check, CheckView(context, view));
  if (edit_version != check.edit_version) {
    return Aborted("edit_version is {}, but publication {} is the newest: check the draft again", edit_version,
                   check.edit_version);
  }
  ENFILADE_ASSIGN_OR_RETURN(const storage::OverlayState state, edits_.ReadOverlay(context, key.site, key.map));
  edit::Overlay theirs;
  if (state.overlay) {
    ENFILADE_ASSIGN_OR_RETURN(theirs, DrawOverlay(context, rasters_.revisions, {key.site, key.map}, *state.overlay,
                                                  edit_version, view.draft().lattice));
  }
  std::vector<storage::NewMapEdit> settling;
  for (const edit::Conflict& conflict : check.conflicts) {
    const edit::CellBox& box = conflict.region.box;
    const ConflictResolution* const found = ResolutionOf(box, resolutions);
    if (found == nullptr) {
      return Aborted("no resolution settles the conflict of {} x {} cells from ({}, {})", box.width, box.height,
                     box.first_column, box.first_row);
    }
    if (found->mine) continue;
    // Their cells, instruction by instruction. Others in the box are not in conflict, and stay the draft's.
    edit::Overlay contradicted;
    contradicted.Draw({Instruction::kOccupied, conflict.cells, false});
    for (const Instruction instruction :
         {Instruction::kNone, Instruction::kUnknown, Instruction::kFree, Instruction::kOccupied}) {
      edit::Overlay marks;
      for (int row = box.first_row; row < box.end_row(); ++row) {
        for (int column = box.first_column; column < box.end_column(); ++column) {
          if (contradicted.At(column, row) == Instruction::kNone || theirs.At(column, row) != instruction) continue;
          const edit::LatticePoint cell{column * edit::kUnitsPerCell, row * edit::kUnitsPerCell};
          marks.Draw({Instruction::kOccupied, edit::Line{{cell}}, false});
        }
      }
      if (marks.empty()) continue;
      const Instruction said = instruction == Instruction::kNone ? Instruction::kClear : instruction;
      settling.push_back({NewUuid(), author, {said, edit::PatchOf(marks, box), false}});
    }
  }
  return edits_.Rebase(context, key, view.draft().base_edit_version, edit_version, settling);
}

absl::StatusOr<std::vector<ContestedPlace>> MapEdits::ListContested(const storage::CallContext& context,
                                                                    const EditedMap& map) {
  ENFILADE_RETURN_IF_ERROR(rasters_.revisions.List(context, map.site, map.map, 0, 1).status());
  ENFILADE_ASSIGN_OR_RETURN(const storage::OverlayState state, edits_.ReadOverlay(context, map.site, map.map));
  std::vector<ContestedPlace> places;
  if (!state.overlay || state.overlay->tiles.empty()) return places;
  const storage::StoredOverlay& overlay = *state.overlay;
  ENFILADE_ASSIGN_OR_RETURN(const auto witnesses, edits_.ReadWitnesses(context, map.site, map.map));
  if (witnesses.empty()) return places;
  ENFILADE_ASSIGN_OR_RETURN(
      const auto publications,
      rasters_.revisions.ReadPublications(context, map.site, map.map, overlay.first_version - 1, overlay.edit_version));
  for (const storage::LayerWitness& layer : witnesses) {
    ENFILADE_ASSIGN_OR_RETURN(const edit::Witness witness, WitnessOf(context, rasters_, map, layer, overlay.lattice));
    for (edit::Contest& contest : edit::FindContests(publications, overlay.lattice, witness)) {
      places.push_back({std::move(contest), layer.session, overlay.lattice});
    }
  }
  return places;
}

absl::StatusOr<storage::MapDraft> MapEdits::Settle(const storage::CallContext& context, const EditedMap& map,
                                                   absl::Span<const ContestSettlement> settlements,
                                                   const std::string& message, const std::string& author) {
  absl::StatusOr<storage::MapDraft> settled = Aborted("{} keeps changing", NameOfMap(map));
  for (int attempt = 0; attempt < kMaxPublishAttempts; ++attempt) {
    ENFILADE_ASSIGN_OR_RETURN(const std::vector<ContestedPlace> contested, ListContested(context, map));
    std::vector<storage::NewMapEdit> edits;
    std::vector<edit::KeptEdit> kept;
    edit::Lattice lattice;
    for (const ContestSettlement& settlement : settlements) {
      const auto found = std::find_if(contested.begin(), contested.end(), [&](const ContestedPlace& place) {
        return place.contest.region.box == settlement.box && place.session == settlement.session;
      });
      if (found == contested.end()) {
        return Aborted("nothing is contested at {} x {} cells from ({}, {}) by {}: list the contested edits again",
                       settlement.box.width, settlement.box.height, settlement.box.first_column,
                       settlement.box.first_row, NameOf(map.site, settlement.session));
      }
      lattice = found->lattice;
      // An edit that holds is said again: now it is younger than the session.
      const Instruction said = settlement.keep ? found->contest.edited : Instruction::kClear;
      edits.push_back({NewUuid(), author, {said, found->contest.cells, false}});
      kept.push_back(
          {edits.back().id, author, static_cast<std::int64_t>(edits.size()), true, lattice, edits.back().edit});
    }
    storage::NewPublication publication{0, 0, message, {}};
    ENFILADE_ASSIGN_OR_RETURN(publication.revision, Compose(context, map, kept));
    storage::MapDraft draft;
    draft.key = {map.site, map.map, MapDraftId(NewUuid())};
    draft.author = author;
    draft.lattice = lattice;
    draft.base_edit_version = publication.revision.edits->overlay.edit_version - 1;
    settled = edits_.PublishAtOnce(context, draft, edits, publication);
    if (!storage::AreLayersChanged(settled.status())) return settled;
  }
  return settled;
}

}  // namespace enfilade::server
