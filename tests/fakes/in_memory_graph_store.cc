// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/status_macros.h"
#include "tests/fakes/in_memory_stores.h"
#include "tests/fakes/map_rows.h"

namespace enfilade::testing {
namespace {

storage::GraphMap ToGraphMap(const storage::Map& map, const GraphMapRow& row) {
  return {map.id, map.display_name, map.level, map.environment, map.outline, row.T_world_map, row.changed_version};
}

storage::GraphChanges ChangesSince(const SiteRows& site, std::int64_t since) {
  const GraphRows& graph = site.graph;
  storage::GraphChanges changes;
  changes.version = graph.version;
  changes.root = graph.root;
  if (since > graph.version) since = 0;
  changes.complete = since == 0;
  for (const auto& [id, row] : graph.maps) {
    if (row.changed_version > since) changes.maps.push_back(ToGraphMap(site.maps.at(id).map, row));
  }
  for (const auto& [id, row] : graph.link_points) {
    if (row.link_point.point.graph_version > since) changes.link_points.push_back(row.link_point);
  }
  if (changes.complete) return changes;
  for (const auto& [id, version] : graph.removed_maps) {
    if (version > since) changes.removed_maps.push_back(id);
  }
  for (const auto& [id, version] : graph.removed_link_points) {
    if (version > since) changes.removed_link_points.push_back(id);
  }
  return changes;
}

absl::StatusOr<SiteRows*> GetSiteWithGraph(InMemoryDatabase::Access& access, const SiteId& site) {
  SiteRows* const rows = access.FindSite(site);
  if (rows == nullptr || rows->graph.version == 0) return NotFound("the graph of {} does not exist", NameOf(site));
  return rows;
}

void SwitchLinkPoints(GraphRows& graph, const std::vector<LinkPointId>& switched_off, std::int64_t version) {
  for (auto& [id, row] : graph.link_points) {
    graph::LinkPoint& point = row.link_point.point;
    if (point.use == graph::LinkPointUse::kSuspended) continue;
    const bool off = std::find(switched_off.begin(), switched_off.end(), id) != switched_off.end();
    const auto use = off ? graph::LinkPointUse::kSwitchedOff : graph::LinkPointUse::kUsed;
    if (point.use == use) continue;
    point.use = use;
    point.graph_version = version;
  }
}

// The latest change of each map in versions after `since` up to `version`.
std::map<MapId, std::optional<PoseWithCovariance>> PosesBetween(const GraphRows& graph, std::int64_t since,
                                                                std::int64_t version) {
  std::map<MapId, std::optional<PoseWithCovariance>> poses;
  for (const auto& [changed, rows] : graph.map_poses) {
    if (changed <= since || changed > version) continue;
    for (const auto& [map, pose] : rows) poses[map] = pose;
  }
  return poses;
}

// The last kKeptOptimizations, oldest first.
std::vector<std::int64_t> KeptOptimizations(const GraphRows& graph) {
  std::vector<std::int64_t> kept;
  for (auto row = graph.versions.rbegin(); row != graph.versions.rend(); ++row) {
    if (kept.size() == static_cast<std::size_t>(storage::GraphStore::kKeptOptimizations)) break;
    if (row->second.cause == storage::GraphCause::kOptimized) kept.push_back(row->first);
  }
  std::reverse(kept.begin(), kept.end());
  return kept;
}

std::int64_t Store(InMemoryDatabase::Access& access, const SiteId& site, const storage::GraphSolution& solution) {
  GraphRows& graph = access.FindSite(site)->graph;
  const std::int64_t version = access.RaiseVersion(site, storage::GraphCause::kOptimized, "");
  const auto before = PosesBetween(graph, 0, version);
  std::map<MapId, std::optional<PoseWithCovariance>>& poses = graph.map_poses[version];
  for (const storage::MapPose& pose : solution.maps) {
    const auto map = graph.maps.find(pose.map);
    if (map == graph.maps.end()) continue;
    map->second = {pose.T_world_map, version};
    poses[pose.map] = pose.T_world_map;
  }
  for (const MapId& map : solution.unposed) poses[map] = std::nullopt;
  for (const auto& [map, pose] : before) {
    if (solution.complete && pose && !poses.contains(map)) poses[map] = std::nullopt;
  }
  for (const storage::LinkPointPose& pose : solution.link_points) {
    const auto row = graph.link_points.find(pose.link_point);
    if (row == graph.link_points.end()) continue;
    row->second.link_point.T_world_place = pose.T_world_place;
    row->second.link_point.point.graph_version = version;
  }
  SwitchLinkPoints(graph, solution.switched_off, version);
  graph.versions.at(version).optimization = {solution.chi2_before, solution.chi2_after, solution.switched_off,
                                             solution.map_count, solution.residual_count};
  return version;
}

}  // namespace

absl::StatusOr<std::int64_t> InMemoryGraphStore::GetVersion(const storage::CallContext& context,
                                                            const SiteId& site) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  const SiteRows* const rows = access.FindSite(site);
  return rows == nullptr ? 0 : rows->graph.version;
}

absl::StatusOr<storage::GraphChanges> InMemoryGraphStore::ReadChanges(const storage::CallContext& context,
                                                                      const SiteId& site, std::int64_t since) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  ENFILADE_ASSIGN_OR_RETURN(const SiteRows* const rows, access.GetSite(site));
  return ChangesSince(*rows, since);
}

absl::StatusOr<std::int64_t> InMemoryGraphStore::Apply(const storage::CallContext& context, const SiteId& site,
                                                       std::int64_t version,
                                                       const storage::GraphSolution& solution) const {
  const auto graphs = database_.LockGraphs();
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  ENFILADE_ASSIGN_OR_RETURN(const SiteRows* const rows, GetSiteWithGraph(access, site));
  if (rows->graph.version != version) {
    return Aborted("the graph of {} is at version {}, no longer at {}: optimise it again", NameOf(site),
                   rows->graph.version, version);
  }
  return Store(access, site, solution);
}

absl::StatusOr<std::int64_t> InMemoryGraphStore::SolveHeld(
    const storage::CallContext& context, const SiteId& site, std::int64_t since,
    const std::function<absl::StatusOr<storage::GraphSolution>(const storage::GraphChanges&)>& solve) const {
  const auto graphs = database_.LockGraphs();
  storage::GraphChanges changes;
  {
    ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
    ENFILADE_ASSIGN_OR_RETURN(const SiteRows* const rows, GetSiteWithGraph(access, site));
    changes = ChangesSince(*rows, since);
  }
  ENFILADE_ASSIGN_OR_RETURN(const storage::GraphSolution solution, solve(changes));
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  return Store(access, site, solution);
}

absl::StatusOr<std::vector<storage::GraphVersion>> InMemoryGraphStore::ListVersions(const storage::CallContext& context,
                                                                                    const SiteId& site,
                                                                                    std::int64_t before,
                                                                                    int limit) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  std::vector<storage::GraphVersion> versions;
  const SiteRows* const rows = access.FindSite(site);
  if (rows == nullptr) return versions;
  for (auto row = rows->graph.versions.rbegin(); row != rows->graph.versions.rend(); ++row) {
    if (before != 0 && row->first >= before) continue;
    if (versions.size() == static_cast<std::size_t>(limit)) break;
    versions.push_back(row->second);
  }
  return versions;
}

absl::StatusOr<std::int64_t> InMemoryGraphStore::FindLastOptimization(const storage::CallContext& context,
                                                                      const SiteId& site, std::int64_t since) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  const SiteRows* const rows = access.FindSite(site);
  if (rows == nullptr) return 0;
  for (auto row = rows->graph.versions.rbegin(); row != rows->graph.versions.rend() && row->first > since; ++row) {
    if (row->second.cause == storage::GraphCause::kOptimized) return row->first;
  }
  return 0;
}

absl::StatusOr<storage::MapPoseChanges> InMemoryGraphStore::GetMapPoses(const storage::CallContext& context,
                                                                        const SiteId& site, std::int64_t version,
                                                                        std::int64_t since) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  storage::MapPoseChanges changes;
  bool is_kept = false;
  if (const SiteRows* const rows = access.FindSite(site)) {
    const std::vector<std::int64_t> kept = KeptOptimizations(rows->graph);
    is_kept = std::find(kept.begin(), kept.end(), version) != kept.end();
    for (const auto& [map, pose] : PosesBetween(rows->graph, since, version)) {
      if (pose) {
        changes.posed.push_back({map, *pose});
      } else if (since != 0) {
        changes.unposed.push_back(map);
      }
    }
  }
  if (!is_kept || (since == 0 && changes.posed.empty())) {
    return NotFound("version {} of the graph of {} is not one of its last {} optimisations", version, NameOf(site),
                    kKeptOptimizations);
  }
  return changes;
}

absl::StatusOr<std::vector<storage::MapPose>> InMemoryGraphStore::GetPlaces(const storage::CallContext& context,
                                                                            const SiteId& site,
                                                                            const std::vector<MapId>& maps) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  std::vector<storage::MapPose> places;
  const SiteRows* const rows = access.FindSite(site);
  if (rows == nullptr) return places;
  for (const auto& [id, row] : rows->graph.maps) {
    const bool wanted = maps.empty() || std::find(maps.begin(), maps.end(), id) != maps.end();
    if (wanted && row.T_world_map) places.push_back({id, *row.T_world_map});
  }
  return places;
}

absl::StatusOr<std::int64_t> InMemoryGraphStore::SetControlPoints(
    const storage::CallContext& context, const SiteId& site, const std::vector<storage::ControlPoint>& points) const {
  const auto graphs = database_.LockGraphs();
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  ENFILADE_ASSIGN_OR_RETURN(SiteRows* const rows, access.GetSite(site));
  for (const storage::ControlPoint& point : points) {
    if (!(std::abs(point.latitude) <= 90.0) || !(std::abs(point.longitude) <= 180.0) || !point.position.allFinite()) {
      return InvalidArgument("the control point in map {} is out of range", point.map.value());
    }
  }
  for (const storage::ControlPoint& point : points) {
    if (!rows->maps.contains(point.map)) {
      return NotFound("a map of the control points does not exist in {}", NameOf(site));
    }
  }
  rows->graph.control_points = points;
  for (storage::ControlPoint& point : rows->graph.control_points) {
    const rearrange::MapRedirect redirect = ResolveMap(*rows, point.map);
    point.map = redirect.to;
    point.position = redirect.T_to_from * point.position;
  }
  return access.RaiseVersion(site, storage::GraphCause::kGeoreferenced, "");
}

absl::StatusOr<std::vector<storage::ControlPoint>> InMemoryGraphStore::GetControlPoints(
    const storage::CallContext& context, const SiteId& site) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  const SiteRows* const rows = access.FindSite(site);
  return rows == nullptr ? std::vector<storage::ControlPoint>() : rows->graph.control_points;
}

absl::StatusOr<std::vector<storage::StoredPlanTies>> InMemoryGraphStore::ReadPlanTies(
    const storage::CallContext& context, const SiteId& site, const std::vector<std::string>& known) const {
  (void)context, (void)site, (void)known;
  return std::vector<storage::StoredPlanTies>();
}

absl::StatusOr<std::vector<storage::GraphListener::Change>> InMemoryGraphStore::ListVersionsOf(
    const storage::CallContext& context, const std::vector<SiteId>& sites) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  std::vector<storage::GraphListener::Change> versions;
  for (const SiteId& site : sites) {
    const SiteRows* const rows = access.FindSite(site);
    if (rows != nullptr && rows->graph.version > 0) versions.push_back({site, rows->graph.version});
  }
  return versions;
}

absl::StatusOr<std::unique_ptr<storage::GraphListener>> InMemoryGraphStore::Listen(
    const storage::CallContext& context) const {
  return database_.Listen(context);
}

}  // namespace enfilade::testing
