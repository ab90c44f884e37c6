// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/status_macros.h"
#include "tests/fakes/graph_rows.h"
#include "tests/fakes/in_memory_stores.h"
#include "tests/fakes/map_rows.h"
#include "tests/fakes/session_rows.h"

namespace enfilade::testing {
namespace {

double Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

bool Meet(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c, const Eigen::Vector2d& d) {
  const double c_side = Cross(b - a, c - a), d_side = Cross(b - a, d - a);
  const double a_side = Cross(d - c, a - c), b_side = Cross(d - c, b - c);
  return c_side * d_side <= 0.0 && a_side * b_side <= 0.0;
}

// Whether sides that are not neighbours meet.
bool IsSimple(const std::vector<Eigen::Vector2d>& polygon) {
  const std::size_t n = polygon.size();
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = i + 2; j < n; ++j) {
      if (i == 0 && j == n - 1) continue;
      if (Meet(polygon[i], polygon[i + 1], polygon[j], polygon[(j + 1) % n])) return false;
    }
  }
  return true;
}

absl::Status Validate(const storage::Map& map) {
  ENFILADE_RETURN_IF_ERROR(storage::ValidateOutline(map));
  if (!IsSimple(map.outline)) {
    return InvalidArgument("outline is not a simple polygon: its sides must not cross or touch one another");
  }
  if (map.environment != Environment::kIndoor && map.environment != Environment::kOutdoor) {
    return InvalidArgument("the environment {} is unknown", static_cast<int>(map.environment));
  }
  if (map.display_name.empty()) return InvalidArgument("the display name is empty");
  return absl::OkStatus();
}

// ALREADY_EXISTS if another map has the name.
absl::Status CheckName(const SiteRows& site, const storage::Map& map) {
  for (const auto& [id, row] : site.maps) {
    if (id == map.id || row.map.display_name != map.display_name) continue;
    return AlreadyExists("{} has a map with the display name \"{}\" already", NameOf(map.site), map.display_name);
  }
  return absl::OkStatus();
}

std::string ResourceOf(const MapId& map) { return "maps/" + map.value(); }

storage::MapUse UseOf(const SiteRows& site, const MapId& map) {
  storage::MapUse use;
  for (const auto& [id, row] : site.sessions) {
    if (row.session.map == map) use.sessions.push_back(id.value());
  }
  for (const auto& [id, row] : site.graph.link_points) {
    if (row.link_point.point.FindAnchor(map)) use.link_points.push_back(id.value());
  }
  return use;
}

// The map and all that lead to it.
std::set<MapId> RedirectsTo(const SiteRows& site, const MapId& map) {
  std::set<MapId> ids;
  for (const auto& [id, row] : site.maps) {
    if (ResolveMap(site, id).to == map) ids.insert(id);
  }
  return ids;
}

void Write(storage::Map& stored, const storage::Map& map) {
  stored.display_name = map.display_name;
  stored.level = map.level;
  stored.environment = map.environment;
  stored.slam_profile = map.slam_profile;
  stored.outline = map.outline;
}

}  // namespace

absl::StatusOr<storage::Map> InMemoryMapStore::Create(const storage::CallContext& context, const storage::Map& map,
                                                      const storage::RequestId& request_id) const {
  ENFILADE_RETURN_IF_ERROR(Validate(map));
  const auto graphs = database_.LockGraphs();
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  ENFILADE_ASSIGN_OR_RETURN(SiteRows* const site, access.GetSite(map.site));
  for (const auto& [id, row] : site->maps) {
    if (!request_id.empty() && row.request_id.value == request_id.value) {
      ENFILADE_RETURN_IF_ERROR(storage::CheckSameRequest(storage::IsSameRequest(row.request_id, request_id)));
      return row.map;
    }
  }
  if (site->maps.contains(map.id)) return AlreadyExists("{} exists already", NameOf(map.site, map.id));
  ENFILADE_RETURN_IF_ERROR(CheckName(*site, map));
  MapRow& row = site->maps[map.id];
  row.request_id = request_id;
  row.map.site = map.site;
  row.map.id = map.id;
  Write(row.map, map);
  row.map.etag = access.NewEtag();
  row.map.create_time = row.map.update_time = access.Timestamp();
  GraphMapRow& in_graph = site->graph.maps[map.id];
  in_graph.changed_version = access.RaiseVersion(map.site, storage::GraphCause::kMapAdded, ResourceOf(map.id));
  if (site->graph.root.empty()) {
    site->graph.root = map.id;
    in_graph.T_world_map = PoseWithCovariance{};
  }
  return row.map;
}

absl::StatusOr<storage::Map> InMemoryMapStore::Get(const storage::CallContext& context, const SiteId& site,
                                                   const MapId& map) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  const SiteRows* const rows = access.FindSite(site);
  ENFILADE_ASSIGN_OR_RETURN(const MapRow* const row,
                            access.GetMap(site, rows == nullptr ? map : ResolveMap(*rows, map).to));
  return row->map;
}

absl::StatusOr<storage::Map> InMemoryMapStore::GetByDisplayName(const storage::CallContext& context, const SiteId& site,
                                                                const std::string& display_name) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  if (const SiteRows* const rows = access.FindSite(site)) {
    for (const auto& [id, row] : rows->maps) {
      if (row.map.display_name == display_name) return rows->maps.at(ResolveMap(*rows, id).to).map;
    }
  }
  return NotFound("a map \"{}\" in {} does not exist", display_name, NameOf(site));
}

absl::StatusOr<std::vector<storage::Map>> InMemoryMapStore::List(const storage::CallContext& context,
                                                                 const SiteId& site,
                                                                 const storage::PageRequest& page) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  std::vector<storage::Map> maps;
  const SiteRows* const rows = access.FindSite(site);
  if (rows == nullptr) return maps;
  for (auto row = rows->maps.upper_bound(MapId(page.after)); row != rows->maps.end(); ++row) {
    if (maps.size() == static_cast<std::size_t>(page.limit)) break;
    if (!row->second.redirect) maps.push_back(row->second.map);
  }
  return maps;
}

absl::StatusOr<storage::Map> InMemoryMapStore::Update(const storage::CallContext& context,
                                                      const storage::Map& map) const {
  ENFILADE_RETURN_IF_ERROR(Validate(map));
  const auto graphs = database_.LockGraphs();
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  ENFILADE_ASSIGN_OR_RETURN(MapRow* const row, access.GetMapInUse(map.site, map.id));
  if (row->map.etag != map.etag) return Aborted("{} has changed: read it again", NameOf(map.site, map.id));
  SiteRows& site = *access.FindSite(map.site);
  ENFILADE_RETURN_IF_ERROR(CheckName(site, map));
  const std::int64_t version = access.RaiseVersion(map.site, storage::GraphCause::kMapChanged, ResourceOf(map.id));
  if (row->map.level != map.level) {  // the link points' levels change with it
    for (auto& [id, link_point] : site.graph.link_points) {
      graph::LinkPoint& point = link_point.link_point.point;
      if (point.FindAnchor(map.id)) point.graph_version = version;
    }
  }
  Write(row->map, map);
  row->map.etag = access.NewEtag();
  row->map.update_time = access.Timestamp();
  site.graph.maps.at(map.id).changed_version = version;
  return row->map;
}

absl::Status InMemoryMapStore::Delete(const storage::CallContext& context, const SiteId& site, const MapId& map,
                                      std::int64_t etag, bool force) const {
  const auto graphs = database_.LockGraphs();
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  ENFILADE_ASSIGN_OR_RETURN(const MapRow* const row, access.GetMapInUse(site, map));
  if (etag != 0 && etag != row->map.etag) return Aborted("{} has changed: read it again", NameOf(site, map));
  SiteRows& rows = *access.FindSite(site);
  const storage::MapUse use = UseOf(rows, map);
  if (!force) ENFILADE_RETURN_IF_ERROR(storage::ValidateUnused(site, map, use));
  RemoveMap(access, site, map, access.RaiseVersion(site, storage::GraphCause::kMapRemoved, ResourceOf(map)));
  for (const std::string& session : use.sessions) DeleteSession(rows.sessions.at(SessionId(session)));
  std::erase_if(rows.robot_poses, [&](const auto& pose) { return pose.second.map == map; });
  std::erase_if(rows.maps, [gone = RedirectsTo(rows, map)](const auto& entry) { return gone.contains(entry.first); });
  return absl::OkStatus();
}

}  // namespace enfilade::testing
