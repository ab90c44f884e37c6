// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>
#include <utility>
#include <variant>

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "storage/etag.h"
#include "storage/graph/link_point_rules.h"
#include "tests/fakes/graph_rows.h"
#include "tests/fakes/in_memory_stores.h"

namespace enfilade::testing {
namespace {

std::string ResourceOf(const LinkPointId& id) { return "linkPoints/" + id.value(); }

// NOT_FOUND, or ABORTED on a stale etag.
absl::StatusOr<LinkPointRow*> GetRow(InMemoryDatabase::Access& access, const SiteId& site, const LinkPointId& id,
                                     std::int64_t etag) {
  SiteRows* const rows = access.FindSite(site);
  if (rows == nullptr) return NotFound("{} does not exist", NameOf(site, id));
  const auto found = rows->graph.link_points.find(id);
  if (found == rows->graph.link_points.end()) return NotFound("{} does not exist", NameOf(site, id));
  if (etag != 0 && etag != found->second.link_point.etag) return storage::StaleEtag(NameOf(site, id));
  return &found->second;
}

absl::Status CheckMaps(const SiteRows& site, const storage::StoredLinkPoint& link_point) {
  for (const graph::Anchor& anchor : link_point.point.anchors) {
    const auto map = site.maps.find(anchor.map);
    if (map != site.maps.end() && !map->second.redirect) continue;
    return NotFound("{}: one of its maps does not exist: {}", NameOf(link_point.site, link_point.point.id),
                    anchor.map.value());
  }
  return absl::OkStatus();
}

// Stores `changed` in the place of the row, as a new version.
storage::StoredLinkPoint Finish(InMemoryDatabase::Access& access, LinkPointRow& row, storage::StoredLinkPoint changed,
                                storage::GraphCause cause) {
  const SiteId site = changed.site;
  const LinkPointId id = changed.point.id;
  const std::int64_t version = access.RaiseVersion(site, cause, ResourceOf(id));
  changed.point.graph_version = version;
  changed.etag = access.NewEtag();
  changed.update_time = access.Timestamp();
  row.link_point = std::move(changed);
  GraphRows& graph = access.FindSite(site)->graph;
  PlaceLinkPoint(graph, version, id);
  return graph.link_points.at(id).link_point;
}

absl::StatusOr<storage::StoredLinkPoint> Insert(InMemoryDatabase::Access& access,
                                                const storage::StoredLinkPoint& link_point,
                                                const storage::RequestId& request_id) {
  ENFILADE_RETURN_IF_ERROR(storage::ValidateLinkPoint(link_point));
  ENFILADE_ASSIGN_OR_RETURN(SiteRows* const site, access.GetSite(link_point.site));
  auto& rows = site->graph.link_points;
  if (rows.contains(link_point.point.id)) {
    return AlreadyExists("{} exists already", NameOf(link_point.site, link_point.point.id));
  }
  ENFILADE_RETURN_IF_ERROR(CheckMaps(*site, link_point));
  storage::StoredLinkPoint created = link_point;
  created.point.use = graph::LinkPointUse::kUsed;
  created.T_world_place = std::nullopt;
  created.create_time = access.Timestamp();
  ENFILADE_RETURN_IF_ERROR(
      storage::CheckNotRedundant(created, storage::AnchorChange::kAdded, ListLinkPoints(site->graph)));
  LinkPointRow& row = rows[link_point.point.id];
  row.request_id = request_id;
  return Finish(access, row, std::move(created), storage::GraphCause::kLinkPointAdded);
}

absl::StatusOr<storage::StoredLinkPoint> Overwrite(InMemoryDatabase::Access& access,
                                                   const storage::StoredLinkPoint& link_point) {
  ENFILADE_RETURN_IF_ERROR(storage::ValidateLinkPoint(link_point));
  const LinkPointId& id = link_point.point.id;
  ENFILADE_ASSIGN_OR_RETURN(LinkPointRow* const row, GetRow(access, link_point.site, id, 0));
  if (row->link_point.etag != link_point.etag) return storage::StaleEtag(NameOf(link_point.site, id));
  const SiteRows& site = *access.FindSite(link_point.site);
  ENFILADE_RETURN_IF_ERROR(CheckMaps(site, link_point));
  ENFILADE_ASSIGN_OR_RETURN(storage::StoredLinkPoint changed,
                            storage::ApplyUpdate(row->link_point, link_point, ListLinkPoints(site.graph)));
  std::erase_if(row->evidence,
                [&](const storage::Evidence& evidence) { return !changed.point.FindAnchor(evidence.map); });
  return Finish(access, *row, std::move(changed), storage::GraphCause::kLinkPointChanged);
}

absl::StatusOr<storage::StoredLinkPoint> Suspend(InMemoryDatabase::Access& access, const SiteId& site,
                                                 const storage::LinkPointSuspension& change) {
  ENFILADE_ASSIGN_OR_RETURN(LinkPointRow* const row, GetRow(access, site, change.link_point, change.etag));
  ENFILADE_ASSIGN_OR_RETURN(
      storage::StoredLinkPoint changed,
      storage::ApplySuspension(row->link_point, change.suspended, ListLinkPoints(access.FindSite(site)->graph)));
  return Finish(access, *row, std::move(changed), storage::GraphCause::kLinkPointChanged);
}

absl::Status Remove(InMemoryDatabase::Access& access, const SiteId& site, const storage::LinkPointDeletion& change) {
  ENFILADE_RETURN_IF_ERROR(GetRow(access, site, change.link_point, change.etag).status());
  GraphRows& graph = access.FindSite(site)->graph;
  graph.link_points.erase(change.link_point);
  graph.removed_link_points[change.link_point] =
      access.RaiseVersion(site, storage::GraphCause::kLinkPointRemoved, ResourceOf(change.link_point));
  return absl::OkStatus();
}

absl::Status Make(InMemoryDatabase::Access& access, const SiteId& site, const storage::LinkPointChange& change) {
  if (const auto* creation = std::get_if<storage::LinkPointCreation>(&change)) {
    return Insert(access, creation->link_point, "").status();
  }
  if (const auto* update = std::get_if<storage::LinkPointUpdate>(&change)) {
    return Overwrite(access, update->link_point).status();
  }
  if (const auto* suspension = std::get_if<storage::LinkPointSuspension>(&change)) {
    return Suspend(access, site, *suspension).status();
  }
  return Remove(access, site, std::get<storage::LinkPointDeletion>(change));
}

bool Matches(const storage::LinkPointFilter& filter, const graph::LinkPoint& point) {
  return (!filter.map || point.FindAnchor(*filter.map)) && (!filter.kind || point.kind == *filter.kind) &&
         (!filter.state || point.state == *filter.state) && (!filter.use || point.use == *filter.use) &&
         (!filter.candidate || point.is_candidate() == *filter.candidate) && (!filter.tag || point.tag == *filter.tag);
}

// By the ray to the right of the point; a point on an edge may count as either.
bool Contains(const std::vector<Eigen::Vector2d>& polygon, const Eigen::Vector2d& point) {
  bool inside = false;
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    const Eigen::Vector2d &a = polygon[i], &b = polygon[j];
    if ((a.y() > point.y()) == (b.y() > point.y())) continue;
    if (point.x() < a.x() + (b.x() - a.x()) * (point.y() - a.y()) / (b.y() - a.y())) inside = !inside;
  }
  return inside;
}

bool Matches(const SiteRows& site, const storage::LinkPointQuery& query, const storage::StoredLinkPoint& link_point) {
  const graph::LinkPoint& point = link_point.point;
  if (!link_point.T_world_place) return false;
  if (query.candidate && point.is_candidate() != *query.candidate) return false;
  if (!query.with_unused && point.use != graph::LinkPointUse::kUsed) return false;
  if (query.level && !LevelsOf(site, link_point).contains(*query.level)) return false;
  const Eigen::Vector2d position = link_point.T_world_place->pose.translation();
  if (const auto* circle = std::get_if<storage::LinkPointCircle>(&query.area)) {
    return (position - circle->center).norm() <= circle->radius;
  }
  return Contains(std::get<std::vector<Eigen::Vector2d>>(query.area), position);
}

}  // namespace

absl::StatusOr<storage::StoredLinkPoint> InMemoryLinkPointStore::Create(const storage::CallContext& context,
                                                                        const storage::StoredLinkPoint& link_point,
                                                                        const storage::RequestId& request_id) const {
  ENFILADE_RETURN_IF_ERROR(storage::ValidateLinkPoint(link_point));
  const auto graphs = database_.LockGraphs();
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  ENFILADE_ASSIGN_OR_RETURN(SiteRows* const site, access.GetSite(link_point.site));
  for (const auto& [id, row] : site->graph.link_points) {
    if (!request_id.empty() && row.request_id.value == request_id.value) {
      ENFILADE_RETURN_IF_ERROR(storage::CheckSameRequest(storage::IsSameRequest(row.request_id, request_id)));
      return row.link_point;
    }
  }
  return Insert(access, link_point, request_id);
}

absl::StatusOr<storage::StoredLinkPoint> InMemoryLinkPointStore::AddAnchor(const storage::CallContext& context,
                                                                           const SiteId& site,
                                                                           const storage::NewAnchor& added) const {
  ENFILADE_RETURN_IF_ERROR(storage::ValidateAnchors({added.anchor}));
  const auto graphs = database_.LockGraphs();
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  ENFILADE_ASSIGN_OR_RETURN(LinkPointRow* const row, GetRow(access, site, added.link_point, added.etag));
  const SiteRows& rows = *access.FindSite(site);
  storage::StoredLinkPoint only_added = row->link_point;
  only_added.point.anchors = {added.anchor};
  ENFILADE_RETURN_IF_ERROR(CheckMaps(rows, only_added));
  ENFILADE_ASSIGN_OR_RETURN(storage::StoredLinkPoint changed,
                            storage::ApplyAnchor(row->link_point, added, ListLinkPoints(rows.graph)));
  return Finish(access, *row, std::move(changed), storage::GraphCause::kLinkPointChanged);
}

absl::StatusOr<storage::StoredLinkPoint> InMemoryLinkPointStore::Get(const storage::CallContext& context,
                                                                     const SiteId& site, const LinkPointId& id) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  ENFILADE_ASSIGN_OR_RETURN(const LinkPointRow* const row, GetRow(access, site, id, 0));
  return row->link_point;
}

absl::StatusOr<std::vector<storage::StoredLinkPoint>> InMemoryLinkPointStore::List(
    const storage::CallContext& context, const SiteId& site, const storage::LinkPointFilter& filter,
    const storage::PageRequest& page) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  std::vector<storage::StoredLinkPoint> link_points;
  const SiteRows* const rows = access.FindSite(site);
  if (rows == nullptr) return link_points;
  const auto& stored = rows->graph.link_points;
  for (auto row = stored.upper_bound(LinkPointId(page.after)); row != stored.end(); ++row) {
    if (link_points.size() == static_cast<std::size_t>(page.limit)) break;
    if (Matches(filter, row->second.link_point.point)) link_points.push_back(row->second.link_point);
  }
  return link_points;
}

absl::StatusOr<storage::StoredLinkPoint> InMemoryLinkPointStore::Update(
    const storage::CallContext& context, const storage::StoredLinkPoint& link_point) const {
  const auto graphs = database_.LockGraphs();
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  return Overwrite(access, link_point);
}

absl::StatusOr<storage::StoredLinkPoint> InMemoryLinkPointStore::SetSuspended(const storage::CallContext& context,
                                                                              const SiteId& site, const LinkPointId& id,
                                                                              std::int64_t etag, bool suspended) const {
  const auto graphs = database_.LockGraphs();
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  return Suspend(access, site, {id, etag, suspended});
}

absl::Status InMemoryLinkPointStore::Delete(const storage::CallContext& context, const SiteId& site,
                                            const LinkPointId& id, std::int64_t etag) const {
  const auto graphs = database_.LockGraphs();
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  return Remove(access, site, {id, etag});
}

absl::StatusOr<storage::ChangedLinkPoints> InMemoryLinkPointStore::Change(
    const storage::CallContext& context, const SiteId& site,
    const std::vector<storage::LinkPointChange>& changes) const {
  if (changes.empty()) return InvalidArgument("changes is empty: expected at least one change");
  const auto graphs = database_.LockGraphs();
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  ENFILADE_ASSIGN_OR_RETURN(SiteRows* const rows, access.GetSite(site));
  GraphRows before = rows->graph;
  for (std::size_t i = 0; i < changes.size(); ++i) {
    const absl::Status made = Make(access, site, changes[i]);
    if (made.ok()) continue;
    access.RollBack(site, std::move(before));
    return WithContext(made, fmt::format("changes[{}]", i));
  }
  storage::ChangedLinkPoints changed;
  changed.graph_version = rows->graph.version;
  std::set<LinkPointId> listed;
  for (const storage::LinkPointChange& change : changes) {
    const auto row = rows->graph.link_points.find(storage::LinkPointOf(change));
    if (row == rows->graph.link_points.end() || !listed.insert(row->first).second) continue;
    changed.link_points.push_back(row->second.link_point);
  }
  return changed;
}

absl::StatusOr<storage::FoundLinkPoints> InMemoryLinkPointStore::Find(const storage::CallContext& context,
                                                                      const SiteId& site,
                                                                      const storage::LinkPointQuery& query) const {
  ENFILADE_RETURN_IF_ERROR(storage::ValidateQuery(query));
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  storage::FoundLinkPoints found;
  const SiteRows* const rows = access.FindSite(site);
  if (rows == nullptr) return found;
  found.graph_version = rows->graph.version;
  for (const auto& [id, row] : rows->graph.link_points) {
    if (Matches(*rows, query, row.link_point)) found.link_points.push_back(row.link_point);
  }
  if (const auto* circle = std::get_if<storage::LinkPointCircle>(&query.area)) {
    const auto distance = [&](const storage::StoredLinkPoint& link_point) {
      return (link_point.T_world_place->pose.translation() - circle->center).norm();
    };
    std::stable_sort(found.link_points.begin(), found.link_points.end(),
                     [&](const auto& a, const auto& b) { return distance(a) < distance(b); });
  }
  const auto limit = static_cast<std::size_t>(query.limit);
  if (found.link_points.size() > limit)
    found.link_points.erase(found.link_points.begin() + query.limit, found.link_points.end());
  return found;
}

absl::StatusOr<std::vector<storage::StoredLinkPoint>> InMemoryLinkPointStore::ListUnplaced(
    const storage::CallContext& context, const SiteId& site, int limit) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  std::vector<storage::StoredLinkPoint> unplaced;
  const SiteRows* const rows = access.FindSite(site);
  if (rows == nullptr) return unplaced;
  for (const auto& [id, row] : rows->graph.link_points) {
    if (unplaced.size() == static_cast<std::size_t>(limit)) break;
    if (!row.link_point.T_world_place) unplaced.push_back(row.link_point);
  }
  return unplaced;
}

absl::Status InMemoryLinkPointStore::PutEvidence(const storage::CallContext& context, const SiteId& site,
                                                 const storage::Evidence& evidence) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  const absl::Status missing =
      InvalidArgument("the blob {} is not stored in {}: send it first", ToHex(evidence.content.sha256), NameOf(site));
  const SiteRows* const rows = access.FindSite(site);
  if (rows == nullptr) return missing;
  const auto blob = rows->blobs.find(evidence.content.sha256);
  if (blob == rows->blobs.end()) return missing;
  const auto row = GetRow(access, site, evidence.link_point, 0);
  if (!row.ok() || !(*row)->link_point.point.FindAnchor(evidence.map)) {
    return NotFound("{} has no anchor in the map \"{}\"", NameOf(site, evidence.link_point), evidence.map.value());
  }
  std::vector<storage::Evidence>& stored = (*row)->evidence;
  std::erase_if(
      stored, [&](const storage::Evidence& other) { return other.map == evidence.map && other.kind == evidence.kind; });
  stored.push_back(evidence);
  stored.back().content.size = static_cast<std::int64_t>(blob->second.size());
  return absl::OkStatus();
}

absl::StatusOr<std::vector<storage::Evidence>> InMemoryLinkPointStore::ListEvidence(
    const storage::CallContext& context, const SiteId& site, const std::vector<LinkPointId>& link_points) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  std::vector<storage::Evidence> evidence;
  for (const LinkPointId& id : link_points) {
    const auto row = GetRow(access, site, id, 0);
    if (row.ok()) evidence.insert(evidence.end(), (*row)->evidence.begin(), (*row)->evidence.end());
  }
  std::stable_sort(evidence.begin(), evidence.end(), [](const storage::Evidence& a, const storage::Evidence& b) {
    return std::tie(a.link_point, a.map, a.kind) < std::tie(b.link_point, b.map, b.kind);
  });
  return evidence;
}

}  // namespace enfilade::testing
