// SPDX-License-Identifier: Apache-2.0
#include "tests/fakes/graph_rows.h"

#include <algorithm>
#include <tuple>

#include "core/graph/placement.h"

namespace enfilade::testing {
namespace {

std::vector<graph::LinkPoint> UnplacedAt(const GraphRows& graph, const std::vector<MapId>& maps) {
  std::vector<graph::LinkPoint> unplaced;
  for (const auto& [id, row] : graph.link_points) {
    const graph::LinkPoint& point = row.link_point.point;
    const bool joins = std::any_of(maps.begin(), maps.end(), [&](const MapId& map) { return point.FindAnchor(map); });
    if (joins && !row.link_point.T_world_place) unplaced.push_back(point);
  }
  return unplaced;
}

// The oldest of the maps with a place carries the world frame from now on; the oldest of all if none has one.
MapId NextRoot(const SiteRows& site) {
  MapId root;
  std::tuple<bool, TimeNs> best;
  for (const auto& [id, row] : site.graph.maps) {
    const std::tuple<bool, TimeNs> rank{!row.T_world_map, site.maps.at(id).map.create_time};
    if (root.empty() || rank < best) {
      root = id;
      best = rank;
    }
  }
  return root;
}

}  // namespace

std::set<int> LevelsOf(const SiteRows& site, const storage::StoredLinkPoint& link_point) {
  std::set<int> levels;
  for (const graph::Anchor& anchor : link_point.point.anchors) levels.insert(site.maps.at(anchor.map).map.level);
  return levels;
}

std::vector<storage::StoredLinkPoint> ListLinkPoints(const GraphRows& graph) {
  std::vector<storage::StoredLinkPoint> link_points;
  for (const auto& [id, row] : graph.link_points) link_points.push_back(row.link_point);
  return link_points;
}

void PlaceLinkPoint(GraphRows& graph, std::int64_t version, const LinkPointId& link_point) {
  graph::Placement placement;
  std::vector<graph::LinkPoint> next = {graph.link_points.at(link_point).link_point.point};
  while (!next.empty()) {
    for (const MapId& map : placement.UnknownMapsOf(next)) {
      if (const auto& place = graph.maps.at(map).T_world_map) placement.SetPlace(map, *place);
    }
    next = UnplacedAt(graph, placement.Visit(next));
  }
  for (const auto& [map, place] : placement.maps()) graph.maps.at(map) = {place, version};
  for (const auto& [id, place] : placement.link_points()) {
    storage::StoredLinkPoint& placed = graph.link_points.at(id).link_point;
    placed.T_world_place = place;
    placed.point.graph_version = version;
  }
}

void RemoveMap(InMemoryDatabase::Access& access, const SiteId& site_id, const MapId& map, std::int64_t version) {
  SiteRows& site = *access.FindSite(site_id);
  GraphRows& graph = site.graph;
  for (auto row = graph.link_points.begin(); row != graph.link_points.end();) {
    graph::LinkPoint& point = row->second.link_point.point;
    if (point.FindAnchor(map) == nullptr) {
      ++row;
    } else if (point.anchors.size() <= 2) {
      graph.removed_link_points[row->first] = version;
      row = graph.link_points.erase(row);
    } else {
      std::erase_if(point.anchors, [&](const graph::Anchor& anchor) { return anchor.map == map; });
      std::erase_if(row->second.evidence, [&](const storage::Evidence& evidence) { return evidence.map == map; });
      if (point.direction == map) point.direction = MapId();
      point.graph_version = version;
      row->second.link_point.etag = access.NewEtag();
      row->second.link_point.update_time = access.Timestamp();
      ++row;
    }
  }
  std::erase_if(graph.control_points, [&](const storage::ControlPoint& point) { return point.map == map; });
  graph.maps.erase(map);
  graph.removed_maps[map] = version;
  if (graph.root == map) graph.root = NextRoot(site);
  if (graph.root.empty()) return;
  GraphMapRow& root = graph.maps.at(graph.root);
  if (!root.T_world_map) root = {PoseWithCovariance{}, version};
}

}  // namespace enfilade::testing
