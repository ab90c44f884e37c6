// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/status_macros.h"
#include "storage/graph/rearrangement_rules.h"
#include "tests/fakes/in_memory_stores.h"
#include "tests/fakes/map_rows.h"
#include "tests/fakes/rearrangement_journal.h"
#include "tests/fakes/rearrangement_steps.h"

namespace enfilade::testing {
namespace {

absl::Status CheckLease(const SiteRows& rows, const storage::SiteLease& lease) {
  if (rows.lease.token == lease.token) return absl::OkStatus();
  return Aborted("{} has lost the lease on {}", lease.owner, NameOf(lease.site));
}

// A cut is made at a keyframe: scans are relative to the one before them.
rearrange::SessionCut AtKeyframe(const SiteRows& rows, rearrange::SessionCut cut) {
  const auto session = rows.sessions.find(cut.session);
  if (session == rows.sessions.end() || !session->second.mapping) return cut;
  std::optional<std::int64_t> next;
  for (const auto& [id, node] : session->second.mapping->map.nodes) {
    if (node.sequence >= cut.first_sequence) next = std::min(next.value_or(node.sequence), node.sequence);
  }
  cut.first_sequence = next.value_or(cut.first_sequence);
  return cut;
}

// What is done, with the maps that sessions leave.
RearrangementRow PartsOf(const SiteRows& rows, const SiteId& site, const storage::RearrangementChange& change) {
  const rearrange::Rearrangement& rearrangement = change.rearrangement;
  RearrangementRow row;
  storage::StoredRearrangement& stored = row.stored;
  stored.site = site;
  stored.id = change.id;
  stored.reason = rearrangement.reason;
  stored.version_before = change.graph_version;
  for (const rearrange::MapSeed& seed : rearrangement.new_maps) stored.new_maps.push_back(seed.id);
  std::map<SessionId, SessionId> cut_from;
  for (const rearrange::SessionCut& cut : rearrangement.cuts) {
    stored.cuts.push_back(AtKeyframe(rows, cut));
    cut_from[cut.rest] = cut.session;
  }
  stored.moves = rearrangement.moves;
  stored.redirects = rearrangement.redirects;
  for (const graph::LinkPoint& point : rearrangement.link_points) stored.changed_link_points.push_back(point.id);
  stored.removed_link_points = rearrangement.removed_link_points;
  const auto keep_source = [&](const SessionId& of, const SessionId& recorded) {
    const auto found = rows.sessions.find(recorded);
    if (found != rows.sessions.end() && found->second.session.map) row.sources[of] = *found->second.session.map;
  };
  for (const rearrange::SessionCut& cut : stored.cuts) keep_source(cut.session, cut.session);
  for (const rearrange::SessionMove& move : stored.moves) {
    const auto cut = cut_from.find(move.session);
    keep_source(move.session, cut == cut_from.end() ? move.session : cut->second);
  }
  return row;
}

// After a failed step: everything as it was.
void PutBack(const RowsBefore& before, GraphRows graph, SiteRows& rows) {
  rows.graph = std::move(graph);
  rows.robot_poses = before.robot_poses;
  for (const auto& [id, map] : before.maps) {
    if (map) {
      rows.maps[id] = *map;
    } else {
      rows.maps.erase(id);
    }
  }
  for (const auto& [id, session] : before.sessions) {
    if (session) {
      rows.sessions[id] = *session;
    } else {
      rows.sessions.erase(id);
    }
  }
}

absl::StatusOr<RearrangementRow*> GetRearrangement(InMemoryDatabase::Access& access, const SiteId& site,
                                                   const rearrange::RearrangementId& id) {
  if (SiteRows* const rows = access.FindSite(site)) {
    const auto found = rows->rearrangements.find(id);
    if (found != rows->rearrangements.end()) return &found->second;
  }
  return NotFound("{} does not exist", storage::NameOfRearrangement(site, id));
}

}  // namespace

absl::StatusOr<storage::StoredRearrangement> InMemoryRearrangementStore::Apply(
    const storage::CallContext& context, const storage::SiteLease& lease,
    const storage::RearrangementChange& change) const {
  const SiteId& site = lease.site;
  ENFILADE_RETURN_IF_ERROR(storage::ValidateToApply(change.rearrangement));
  const auto graphs = database_.LockGraphs();
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  ENFILADE_ASSIGN_OR_RETURN(SiteRows* const rows, access.GetSite(site));
  if (rows->graph.version != change.graph_version) {
    return Aborted("the graph of {} is at version {}, no longer at {}: decide again", NameOf(site), rows->graph.version,
                   change.graph_version);
  }
  ENFILADE_RETURN_IF_ERROR(CheckLease(*rows, lease));
  if (rows->rearrangements.contains(change.id)) {
    return AlreadyExists("{} exists already", storage::NameOfRearrangement(site, change.id));
  }
  const RearrangedSite rearranged{access, site, *rows, rows->graph.version + 1};
  RearrangementRow row = PartsOf(*rows, site, change);
  ENFILADE_RETURN_IF_ERROR(CheckRearranged(rearranged, change, row));
  KeepBefore(*rows, row);
  GraphRows graph_before = rows->graph;
  if (const absl::Status applied = ApplyRearrangement(rearranged, change, row); !applied.ok()) {
    PutBack(row.before, std::move(graph_before), *rows);
    return applied;
  }
  row.stored.version_after =
      access.RaiseVersion(site, storage::GraphCause::kRearranged, storage::ResourceOfRearrangement(change.id));
  row.stored.actor = context.actor;
  row.stored.create_time = access.Timestamp();
  row.images_after = PresentImages(*rows, row);
  return rows->rearrangements.emplace(change.id, std::move(row)).first->second.stored;
}

absl::StatusOr<storage::StoredRearrangement> InMemoryRearrangementStore::Undo(
    const storage::CallContext& context, const storage::SiteLease& lease, const rearrange::RearrangementId& id) const {
  const SiteId& site = lease.site;
  const auto graphs = database_.LockGraphs();
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  ENFILADE_ASSIGN_OR_RETURN(SiteRows* const rows, access.GetSite(site));
  ENFILADE_RETURN_IF_ERROR(CheckLease(*rows, lease));
  ENFILADE_ASSIGN_OR_RETURN(RearrangementRow* const row, GetRearrangement(access, site, id));
  const RearrangedSite rearranged{access, site, *rows, rows->graph.version + 1};
  ENFILADE_RETURN_IF_ERROR(CheckUnchanged(rearranged, *row));
  UndoRearrangement(rearranged, *row);
  row->stored.version_undone =
      access.RaiseVersion(site, storage::GraphCause::kRearranged, storage::ResourceOfRearrangement(id));
  row->stored.undo_time = access.Timestamp();
  return row->stored;
}

absl::StatusOr<rearrange::MapRedirect> InMemoryRearrangementStore::Resolve(const storage::CallContext& context,
                                                                           const SiteId& site, const MapId& map) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  const SiteRows* const rows = access.FindSite(site);
  return rows == nullptr ? rearrange::MapRedirect{map, map, {}} : ResolveMap(*rows, map);
}

absl::StatusOr<storage::StoredRearrangement> InMemoryRearrangementStore::Get(
    const storage::CallContext& context, const SiteId& site, const rearrange::RearrangementId& id) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  ENFILADE_ASSIGN_OR_RETURN(const RearrangementRow* const row, GetRearrangement(access, site, id));
  return row->stored;
}

absl::StatusOr<std::vector<storage::StoredRearrangement>> InMemoryRearrangementStore::List(
    const storage::CallContext& context, const SiteId& site, std::int64_t before, int limit) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  std::vector<storage::StoredRearrangement> listed;
  const SiteRows* const rows = access.FindSite(site);
  if (rows == nullptr) return listed;
  for (const auto& [id, row] : rows->rearrangements) {
    if (before == 0 || row.stored.version_after < before) listed.push_back(row.stored);
  }
  std::sort(listed.begin(), listed.end(),
            [](const auto& a, const auto& b) { return a.version_after > b.version_after; });
  if (listed.size() > static_cast<std::size_t>(limit)) listed.resize(static_cast<std::size_t>(limit));
  return listed;
}

}  // namespace enfilade::testing
