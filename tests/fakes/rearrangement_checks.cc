// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/status_macros.h"
#include "storage/graph/rearrangement_rules.h"
#include "tests/fakes/rearrangement_journal.h"
#include "tests/fakes/rearrangement_steps.h"

namespace enfilade::testing {
namespace {

// Whether the rearrangement moves the session, or anything that is left of it.
bool IsMoved(const storage::StoredRearrangement& stored, const SessionId& session) {
  return std::any_of(stored.moves.begin(), stored.moves.end(),
                     [&](const rearrange::SessionMove& move) { return move.session == session; });
}

bool IsChanged(const storage::StoredRearrangement& stored, const LinkPointId& id) {
  const auto& changed = stored.changed_link_points;
  const auto& removed = stored.removed_link_points;
  return std::find(changed.begin(), changed.end(), id) != changed.end() ||
         std::find(removed.begin(), removed.end(), id) != removed.end();
}

// A session in `map` that the rearrangement does not move; null if there is none.
const SessionId* FindOtherSession(const SiteRows& site, const storage::StoredRearrangement& stored, const MapId& map) {
  for (const auto& [id, row] : site.sessions) {
    if (!row.deleted && row.session.map == map && !IsMoved(stored, id)) return &id;
  }
  return nullptr;
}

const LinkPointId* FindOtherLinkPoint(const SiteRows& site, const storage::StoredRearrangement& stored,
                                      const MapId& map) {
  for (const auto& [id, row] : site.graph.link_points) {
    if (row.link_point.point.FindAnchor(map) != nullptr && !IsChanged(stored, id)) return &id;
  }
  return nullptr;
}

absl::Status CheckCuts(const RearrangedSite& site, const storage::StoredRearrangement& stored) {
  for (const rearrange::SessionCut& cut : stored.cuts) {
    std::int64_t begin = 0;  // where the cut before it is
    for (const rearrange::SessionCut& other : stored.cuts) {
      if (other.session != cut.session || other.rest == cut.rest || other.first_sequence > cut.first_sequence) continue;
      begin = std::max(begin, other.first_sequence);
    }
    bool before = false, behind = false;
    if (const auto& mapping = site.rows.sessions.at(cut.session).mapping) {
      for (const auto& [id, node] : mapping->map.nodes) {
        before = before || (node.sequence >= begin && node.sequence < cut.first_sequence);
        behind = behind || node.sequence >= cut.first_sequence;
      }
    }
    if (!before || !behind) return storage::NothingToCutOff(site.id, cut.session, cut.first_sequence);
  }
  return absl::OkStatus();
}

absl::Status CheckIds(const RearrangedSite& site, const rearrange::Rearrangement& rearrangement) {
  for (const rearrange::SessionCut& cut : rearrangement.cuts) {
    if (!site.rows.sessions.contains(cut.rest)) continue;
    return AlreadyExists("the id of a session's rest is taken: {}", cut.rest.value());
  }
  for (const rearrange::MapSeed& map : rearrangement.new_maps) {
    if (site.rows.maps.contains(map.id)) return AlreadyExists("a new map's id is taken: {}", map.id.value());
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status CheckRearranged(const RearrangedSite& site, const storage::RearrangementChange& change,
                             const RearrangementRow& row) {
  const rearrange::Rearrangement& rearrangement = change.rearrangement;
  std::map<MapId, bool> maps;
  for (const auto& [id, map] : site.rows.maps) maps[id] = map.redirect.has_value();
  ENFILADE_RETURN_IF_ERROR(storage::CheckRearrangedMaps(site.id, rearrangement, std::move(maps)));
  std::map<SessionId, storage::SessionToRearrange> sessions;
  for (const auto& [id, session] : site.rows.sessions) {
    if (session.deleted) continue;
    const storage::Session& stored = session.session;
    sessions[id] = {stored.map.value_or(MapId()), stored.state, stored.records_deleted};
  }
  ENFILADE_RETURN_IF_ERROR(storage::CheckRearrangedSessions(site.id, rearrangement, sessions));
  ENFILADE_RETURN_IF_ERROR(CheckCuts(site, row.stored));
  for (const rearrange::MapRedirect& redirect : rearrangement.redirects) {
    const SessionId* session = FindOtherSession(site.rows, row.stored, redirect.from);
    if (session != nullptr) return storage::SessionIsLeft(site.id, *session, redirect.from);
    const LinkPointId* point = FindOtherLinkPoint(site.rows, row.stored, redirect.from);
    if (point != nullptr) return storage::AnchorIsLeft(site.id, *point, redirect.from);
    if (site.rows.graph.root == redirect.from) return storage::RootWouldDisappear(redirect.from);
  }
  return CheckIds(site, rearrangement);
}

absl::Status CheckUnchanged(const RearrangedSite& site, const RearrangementRow& row) {
  const std::string name = storage::NameOfRearrangement(site.id, row.stored.id);
  if (row.stored.version_undone != 0) return storage::AlreadyUndone(name);
  if (row.stored.undo_expired) return storage::UndoExpired(name);
  const Images present = PresentImages(site.rows, row);
  for (const auto& [of, after] : row.images_after) {
    if (present.at(of) != after) return storage::ChangedSince(name, of.first, of.second);
  }
  for (const MapId& map : row.stored.new_maps) {
    const LinkPointId* point = FindOtherLinkPoint(site.rows, row.stored, map);
    if (point != nullptr) return storage::HasComeSince(name, "link point " + point->value(), map);
    const SessionId* session = FindOtherSession(site.rows, row.stored, map);
    if (session != nullptr) return storage::HasComeSince(name, "session " + session->value(), map);
  }
  return absl::OkStatus();
}

}  // namespace enfilade::testing
