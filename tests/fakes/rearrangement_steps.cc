// SPDX-License-Identifier: Apache-2.0
#include "tests/fakes/rearrangement_steps.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/status_macros.h"
#include "storage/graph/link_point_rules.h"
#include "tests/fakes/graph_rows.h"
#include "tests/fakes/map_rows.h"
#include "tests/fakes/session_rows.h"

namespace enfilade::testing {
namespace {

// The smallest free number behind the prefix.
// As storage/postgres/maps/numbered_map.h.
std::string FreeName(const SiteRows& site, const std::string& prefix) {
  const auto name = [&](std::int64_t number) { return fmt::format("{} {}", prefix, number); };
  const auto is_taken = [&](std::int64_t number) {
    return std::any_of(site.maps.begin(), site.maps.end(),
                       [&](const auto& entry) { return entry.second.map.display_name == name(number); });
  };
  std::int64_t taken = 0;
  std::int64_t free = 1;
  for (; is_taken(free); free *= 2) taken = free;
  while (free - taken > 1) {
    const std::int64_t middle = (taken + free) / 2;
    (is_taken(middle) ? taken : free) = middle;
  }
  return name(free);
}

// In the place in the world that the sessions which move there give it.
void AddMaps(const RearrangedSite& site, const rearrange::Rearrangement& rearrangement, const RearrangementRow& row) {
  for (const rearrange::MapSeed& seed : rearrangement.new_maps) {
    storage::Map map;
    map.site = site.id;
    map.id = seed.id;
    map.display_name = FreeName(site.rows, seed.name_prefix);
    map.level = seed.level;
    map.environment = seed.environment;
    map.slam_profile = seed.slam_profile;
    map.etag = site.access.NewEtag();
    map.create_time = map.update_time = site.access.Timestamp();
    site.rows.maps[seed.id].map = std::move(map);
    GraphMapRow& in_graph = site.rows.graph.maps[seed.id];
    in_graph.changed_version = site.version;
    for (const rearrange::SessionMove& move : rearrangement.moves) {
      if (move.to != seed.id || in_graph.T_world_map) continue;
      const auto& source = site.rows.graph.maps.at(row.sources.at(move.session)).T_world_map;
      if (!source) continue;
      in_graph.T_world_map = Compose(*source, {Inverse(move.T_to_from), Eigen::Matrix3d::Zero()});
    }
  }
}

void MoveRobotPose(const RearrangedSite& site, const MapId& to, const Pose2& T_to_from, storage::RobotPose& pose,
                   RearrangementRow& row) {
  pose.map = to;
  pose.T_map_robot = rearrange::Moved(T_to_from, pose.T_map_robot);
  pose.version = site.access.NewEtag();
  row.moved_robot_poses[pose.robot] = pose.version;
}

void MoveAll(const RearrangedSite& site, const rearrange::Rearrangement& rearrangement, RearrangementRow& row) {
  for (const rearrange::SessionMove& move : rearrangement.moves) {
    MoveSession(site.rows.sessions.at(move.session), move);
    for (auto& [robot, pose] : site.rows.robot_poses) {
      if (pose.session != move.session || pose.map != row.sources.at(move.session)) continue;
      MoveRobotPose(site, move.to, move.T_to_from, pose, row);
    }
  }
  for (const rearrange::MapRedirect& redirect : rearrangement.redirects) {
    for (auto& [robot, pose] : site.rows.robot_poses) {
      if (pose.map == redirect.from) MoveRobotPose(site, redirect.to, redirect.T_to_from, pose, row);
    }
    for (storage::ControlPoint& point : site.rows.graph.control_points) {
      if (point.map != redirect.from) continue;
      point.map = redirect.to;
      point.position = redirect.T_to_from * point.position;
    }
  }
}

// Where evidence from `map` goes if its link point is anchored in `to`: first choices first.
std::vector<rearrange::MapRedirect> WaysInto(const MapId& to, const rearrange::Rearrangement& rearrangement,
                                             const RearrangementRow& row) {
  std::vector<rearrange::MapRedirect> ways = {{to, to, {}}};
  for (const rearrange::MapRedirect& redirect : rearrangement.redirects) {
    if (redirect.to == to) ways.push_back(redirect);
  }
  for (const rearrange::SessionMove& move : rearrangement.moves) {
    if (move.to == to) ways.push_back({row.sources.at(move.session), to, move.T_to_from});
  }
  return ways;
}

// Evidence stays with the anchor of its map; that of a map without an anchor goes where the map's sessions have gone.
// An anchor has the evidence of one kind from one map.
std::vector<storage::Evidence> MovedEvidence(const graph::LinkPoint& point, const std::vector<storage::Evidence>& all,
                                             const rearrange::Rearrangement& rearrangement,
                                             const RearrangementRow& row) {
  std::vector<storage::Evidence> moved;
  for (const graph::Anchor& anchor : point.anchors) {
    std::map<storage::EvidenceKind, MapId> taken;
    for (const rearrange::MapRedirect& way : WaysInto(anchor.map, rearrangement, row)) {
      for (storage::Evidence evidence : all) {
        if (evidence.map != way.from || taken.emplace(evidence.kind, way.from).first->second != way.from) continue;
        const bool is_there = std::any_of(moved.begin(), moved.end(), [&](const storage::Evidence& other) {
          return other.map == anchor.map && other.kind == evidence.kind;
        });
        if (is_there) continue;
        evidence.map = anchor.map;
        if (evidence.T_map_robot) evidence.T_map_robot = way.T_to_from * *evidence.T_map_robot;
        moved.push_back(std::move(evidence));
      }
    }
  }
  return moved;
}

absl::Status PutLinkPoint(const RearrangedSite& site, const graph::LinkPoint& point,
                          const rearrange::Rearrangement& rearrangement, const RearrangementRow& row) {
  for (const graph::Anchor& anchor : point.anchors) {
    const auto map = site.rows.maps.find(anchor.map);
    if (map == site.rows.maps.end() || map->second.redirect) {
      return NotFound("{}: one of its maps does not exist", NameOf(site.id, point.id));
    }
  }
  auto& rows = site.rows.graph.link_points;
  const bool is_new = !rows.contains(point.id);
  LinkPointRow& put = rows[point.id];
  storage::StoredLinkPoint& stored = put.link_point;
  if (is_new) {
    stored.site = site.id;
    stored.point = point;
    stored.point.use = graph::LinkPointUse::kUsed;
    stored.create_time = site.access.Timestamp();
  }
  stored.point.kind = point.kind;
  stored.point.direction = point.direction;
  stored.point.anchors = point.anchors;
  stored.point.graph_version = site.version;
  stored.T_world_place = std::nullopt;
  stored.etag = site.access.NewEtag();
  stored.update_time = site.access.Timestamp();
  const absl::Status redundant =
      storage::CheckNotRedundant(stored, storage::AnchorChange::kMoved, ListLinkPoints(site.rows.graph));
  if (!redundant.ok()) {
    return AlreadyExists("{} would be a second one: {}", NameOf(site.id, point.id), std::string(redundant.message()));
  }
  const auto& before = row.before.link_points.at(point.id);
  if (before) put.evidence = MovedEvidence(point, before->evidence, rearrangement, row);
  return absl::OkStatus();
}

absl::Status ChangeLinkPoints(const RearrangedSite& site, const rearrange::Rearrangement& rearrangement,
                              const RearrangementRow& row) {
  auto& rows = site.rows.graph.link_points;
  for (const LinkPointId& id : rearrangement.removed_link_points) {
    if (rows.erase(id) == 0) return NotFound("{} does not exist", NameOf(site.id, id));
    site.rows.graph.removed_link_points[id] = site.version;
  }
  // All of them first, so that no anchor meets one of another frame.
  for (const graph::LinkPoint& point : rearrangement.link_points) {
    if (const auto found = rows.find(point.id); found != rows.end()) found->second.link_point.point.anchors.clear();
  }
  for (const graph::LinkPoint& point : rearrangement.link_points) {
    ENFILADE_RETURN_IF_ERROR(PutLinkPoint(site, point, rearrangement, row));
  }
  for (const graph::LinkPoint& point : rearrangement.link_points) {
    PlaceLinkPoint(site.rows.graph, site.version, point.id);
  }
  return absl::OkStatus();
}

absl::Status ChangeRasters(const RearrangedSite& site, const storage::RearrangementChange& change,
                           const RearrangementRow& row) {
  for (const storage::RearrangedRaster& raster : change.rasters) {
    if (!raster.revision) continue;
    storage::NewRevision revision = *raster.revision;
    revision.layers_version = raster.layers_version;
    ENFILADE_RETURN_IF_ERROR(StoreRevision(site.access, site.id, raster.map, revision, {}).status());
    site.rows.maps.at(raster.map).map.state = storage::MapState::kReady;
  }
  for (const storage::RearrangedRaster& raster : change.rasters) {
    MapRow& map = site.rows.maps.at(raster.map);
    ++map.layers_version;
    map.runs.clear();
  }
  const auto& redirects = change.rearrangement.redirects;
  for (const auto& [session, source] : row.sources) {
    const bool disappears = std::any_of(redirects.begin(), redirects.end(),
                                        [&](const rearrange::MapRedirect& way) { return way.from == source; });
    if (disappears) continue;
    std::erase_if(site.rows.maps.at(source).layers,
                  [&](const storage::MapLayer& layer) { return layer.session == session; });
  }
  for (const storage::RearrangedRaster& raster : change.rasters) {
    for (const storage::EnteringLayer& layer : raster.entering) {
      AddTopLayer(site.rows.maps.at(raster.map), layer.session, layer.raster);
    }
  }
  return absl::OkStatus();
}

void Redirect(const RearrangedSite& site, const rearrange::Rearrangement& rearrangement) {
  for (const rearrange::MapRedirect& redirect : rearrangement.redirects) {
    site.rows.maps.at(redirect.from).redirect = redirect;
    site.rows.graph.maps.erase(redirect.from);
    site.rows.graph.removed_maps[redirect.from] = site.version;
  }
}

}  // namespace

absl::Status ApplyRearrangement(const RearrangedSite& site, const storage::RearrangementChange& change,
                                RearrangementRow& row) {
  const rearrange::Rearrangement& rearrangement = change.rearrangement;
  CutSessions(site.rows, row.stored.cuts);
  AddMaps(site, rearrangement, row);
  MoveAll(site, rearrangement, row);
  ENFILADE_RETURN_IF_ERROR(ChangeLinkPoints(site, rearrangement, row));
  ENFILADE_RETURN_IF_ERROR(ChangeRasters(site, change, row));
  Redirect(site, rearrangement);
  return absl::OkStatus();
}

}  // namespace enfilade::testing
