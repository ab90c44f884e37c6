// SPDX-License-Identifier: Apache-2.0
#include "storage/graph/rearrangement_rules.h"
#include "tests/fakes/graph_rows.h"
#include "tests/fakes/rearrangement_steps.h"
#include "tests/fakes/session_rows.h"

namespace enfilade::testing {
namespace {

bool IsSame(const std::optional<PoseWithCovariance>& a, const std::optional<PoseWithCovariance>& b) {
  if (!a || !b) return a.has_value() == b.has_value();
  return a->pose == b->pose && a->covariance == b->covariance;
}

// In its former place, unless the map that it became a part of has been moved since: then beside it.
void RestoreMaps(const RearrangedSite& site, const RearrangementRow& row) {
  GraphRows& graph = site.rows.graph;
  for (const rearrange::MapRedirect& redirect : row.stored.redirects) {
    site.rows.maps.at(redirect.from).redirect.reset();
    const auto& target = graph.maps.at(redirect.to).T_world_map;
    const auto& target_before = row.before.places.at(redirect.to);
    GraphMapRow& place = graph.maps[redirect.from];
    place.changed_version = site.version;
    if (!target || (target_before && IsSame(target, target_before->T_world_map))) {
      place.T_world_map = row.before.places.at(redirect.from)->T_world_map;
    } else {
      place.T_world_map = PoseWithCovariance{target->pose * redirect.T_to_from, target->covariance};
    }
    graph.removed_maps.erase(redirect.from);
  }
}

void RestoreLinkPoint(const RearrangedSite& site, const LinkPointId& id, const std::optional<LinkPointRow>& before) {
  GraphRows& graph = site.rows.graph;
  if (!before) {
    graph.link_points.erase(id);
    graph.removed_link_points[id] = site.version;
    return;
  }
  graph.removed_link_points.erase(id);
  LinkPointRow& row = graph.link_points.try_emplace(id, *before).first->second;
  row.link_point.point.kind = before->link_point.point.kind;
  row.link_point.point.direction = before->link_point.point.direction;
  row.link_point.point.anchors = before->link_point.point.anchors;
  row.link_point.point.graph_version = site.version;
  row.link_point.T_world_place = std::nullopt;
  row.link_point.etag = site.access.NewEtag();
  row.link_point.update_time = site.access.Timestamp();
  row.evidence = before->evidence;
}

void RestoreSessions(const RearrangedSite& site, const RearrangementRow& row) {
  for (const rearrange::SessionCut& cut : row.stored.cuts) {
    UncutSession(site.rows, cut, *row.before.sessions.at(cut.session));
  }
  for (const auto& [id, before] : row.before.sessions) {
    if (!before) continue;  // a rest
    SessionRow& session = site.rows.sessions.at(id);
    session.session.map = before->session.map;
    session.session.entry.T_map_robot = before->session.entry.T_map_robot;
    if (!session.mapping || !before->mapping) continue;
    session.mapping->map.nodes = before->mapping->map.nodes;
    for (auto& [submap_id, submap] : session.mapping->map.submaps) {
      submap.T_map_submap = before->mapping->map.submaps.at(submap_id).T_map_submap;
    }
  }
}

// Those of robots that have reported since go back with their session, or with the map that disappears.
void RestoreRobotPoses(const RearrangedSite& site, const RearrangementRow& row) {
  const std::set<MapId> new_maps(row.stored.new_maps.begin(), row.stored.new_maps.end());
  for (auto& [robot, pose] : site.rows.robot_poses) {
    const auto moved = row.moved_robot_poses.find(robot);
    if (moved != row.moved_robot_poses.end() && moved->second == pose.version) {
      pose = row.before.robot_poses.at(robot);
      pose.version = site.access.NewEtag();
      continue;
    }
    for (const rearrange::SessionMove& move : row.stored.moves) {
      if (pose.map != move.to || (pose.session != move.session && !new_maps.contains(move.to))) continue;
      pose.map = row.sources.at(move.session);
      pose.T_map_robot = rearrange::Moved(Inverse(move.T_to_from), pose.T_map_robot);
      pose.version = site.access.NewEtag();
      break;
    }
  }
}

// The map's layers, and its revision of before under the next number: revisions are never taken back.
void RestoreRasters(const RearrangedSite& site, const RearrangementRow& row) {
  for (const auto& [id, before] : row.before.maps) {
    const auto layers = std::pair(std::string(storage::image::kLayers), id.value());
    MapRow& map = site.rows.maps.at(id);
    if (row.images_before.at(layers) != row.images_after.at(layers)) {
      map.layers = before ? before->layers : std::vector<storage::MapLayer>();
      map.runs.clear();
      ++map.layers_version;
      for (storage::MapLayer& layer : map.layers) layer.version = map.layers_version;
    }
    if (!before || before->revisions.empty()) continue;
    RevisionRow old = before->revisions.back();
    if (old.revision.content_sha256 == map.revisions.back().revision.content_sha256) continue;
    old.revision.number = static_cast<std::int64_t>(map.revisions.size()) + 1;
    old.revision.create_time = site.access.Timestamp();
    map.map.current_revision = old.revision.number;
    map.revisions.push_back(std::move(old));
  }
}

// A map that began with the rearrangement leads back to where its sessions came from.
void RedirectNewMaps(const RearrangedSite& site, const RearrangementRow& row) {
  for (const MapId& map : row.stored.new_maps) {
    auto& redirect = site.rows.maps.at(map).redirect;
    for (const rearrange::SessionMove& move : row.stored.moves) {
      if (move.to != map || redirect) continue;
      redirect = {map, row.sources.at(move.session), Inverse(move.T_to_from)};
    }
    site.rows.graph.maps.erase(map);
    site.rows.graph.removed_maps[map] = site.version;
  }
}

}  // namespace

void UndoRearrangement(const RearrangedSite& site, const RearrangementRow& row) {
  RestoreMaps(site, row);
  for (const auto& [id, before] : row.before.link_points) RestoreLinkPoint(site, id, before);
  RestoreSessions(site, row);
  for (const auto& [of, image] : row.images_before) {
    if (of.first == storage::image::kControlPoints) site.rows.graph.control_points = row.before.control_points;
  }
  RestoreRobotPoses(site, row);
  RestoreRasters(site, row);
  RedirectNewMaps(site, row);
  for (const auto& [id, before] : row.before.link_points) {
    if (before) PlaceLinkPoint(site.rows.graph, site.version, id);
  }
}

}  // namespace enfilade::testing
