// SPDX-License-Identifier: Apache-2.0
#include "server/app/rearrange/rearranger.h"

#include <set>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/base/uuid.h"
#include "server/app/rearrange/layer_renderer.h"
#include "spdlog/spdlog.h"

namespace enfilade::server {
namespace {

// After these errors the change may have been committed.
bool MayBeCommitted(const absl::Status& status) {
  return status.ok() || absl::IsUnavailable(status) || absl::IsDeadlineExceeded(status) || absl::IsCancelled(status);
}

}  // namespace

absl::StatusOr<storage::StoredRearrangement> Rearranger::Apply(const storage::CallContext& context,
                                                               const storage::SiteLease& lease,
                                                               const rearrange::Rearrangement& rearrangement,
                                                               std::int64_t graph_version, bool by_people) const {
  ENFILADE_RETURN_IF_ERROR(rearrange::Validate(rearrangement));
  storage::RearrangementChange change;
  change.id = rearrange::RearrangementId(NewUuid());
  change.rearrangement = rearrangement;
  change.graph_version = graph_version;
  change.by_people = by_people;
  LayerRenderer renderer(context, stores_, profiles_, lease.site, rearrangement);
  ENFILADE_ASSIGN_OR_RETURN(change.rasters, renderer.Render());
  if (edits_ != nullptr) ENFILADE_RETURN_IF_ERROR(edits_->Adopt(context, lease.site, change));
  absl::StatusOr<storage::StoredRearrangement> applied = stores_.rearrangements.Apply(context, lease, change);
  if (MayBeCommitted(applied.status())) graphs_.MarkChanged(lease.site);
  if (applied.ok()) {
    spdlog::info("maps of {} rearranged ({}): {}", lease.site.value(), change.id.value(), rearrangement.reason);
  }
  return applied;
}

absl::StatusOr<storage::StoredRearrangement> Rearranger::Undo(const storage::CallContext& context,
                                                              const storage::SiteLease& lease,
                                                              const rearrange::RearrangementId& id) const {
  absl::StatusOr<storage::StoredRearrangement> undone = stores_.rearrangements.Undo(context, lease, id);
  if (MayBeCommitted(undone.status())) graphs_.MarkChanged(lease.site);
  if (undone.ok()) {
    RecomposeEdited(context, lease.site, *undone);
    spdlog::info("rearrangement {} of {} undone", id.value(), lease.site.value());
  }
  return undone;
}

// The layers of before are back; edits lie over them as over any others.
void Rearranger::RecomposeEdited(const storage::CallContext& context, const SiteId& site,
                                 const storage::StoredRearrangement& undone) const {
  if (edits_ == nullptr) return;
  std::set<MapId> maps;
  for (const rearrange::MapRedirect& redirect : undone.redirects) maps.insert({redirect.from, redirect.to});
  for (const rearrange::SessionMove& move : undone.moves) maps.insert(move.to);
  for (const MapId& map : maps) {
    const absl::Status composed = edits_->Recompose(context, {site, map});
    if (composed.ok() || absl::IsNotFound(composed)) continue;
    spdlog::error("map {} was not composed again: {}", map.value(), composed.ToString());
  }
}

}  // namespace enfilade::server
