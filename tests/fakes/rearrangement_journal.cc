// SPDX-License-Identifier: Apache-2.0
#include "tests/fakes/rearrangement_journal.h"

#include "core/base/sha256.h"
#include "fmt/format.h"
#include "storage/graph/rearrangement_rules.h"
#include "tests/fakes/session_rows.h"

namespace enfilade::testing {
namespace {

// Shortest texts that read back as the same numbers: equal if and only if the values are.
std::string Exactly(const Pose2& pose) { return fmt::format("({} {} {})", pose.x, pose.y, pose.yaw); }
std::string Exactly(const PoseWithCovariance& pose) {
  std::string text = Exactly(pose.pose);
  for (int i = 0; i < 9; ++i) text += fmt::format(" {}", pose.covariance(i / 3, i % 3));
  return text;
}

std::string ImageOf(const MapRow& row) {
  std::string text = fmt::format("level {} environment {}", row.map.level, static_cast<int>(row.map.environment));
  if (row.redirect) text += fmt::format(" to {} {}", row.redirect->to.value(), Exactly(row.redirect->T_to_from));
  if (!row.revisions.empty()) text += " raster " + ToHex(row.revisions.back().revision.content_sha256);
  return text;
}

std::string ImageOfLayers(const MapRow& row) {
  std::string text;
  for (const storage::MapLayer& layer : row.layers) {
    text += fmt::format("layer {}:", layer.session.value_or(SessionId()).value());
    for (const storage::TileRef& tile : layer.raster.tiles) {
      text += fmt::format(" {},{} {}", tile.key.row, tile.key.column, ToHex(tile.sha256));
    }
  }
  return text;
}

std::string ImageOf(const SessionRow& row) {
  const storage::Session session = WithProgress(row);
  std::string text =
      fmt::format("in {} state {} records {} {} mapped {} used {} keyframes {}", session.map.value_or(MapId()).value(),
                  static_cast<int>(session.state), session.acknowledged_sequence, session.highest_sequence,
                  session.mapped_sequence, session.mapping_counts.used, session.mapping_counts.keyframes);
  if (session.entry.T_map_robot) text += " entry " + Exactly(*session.entry.T_map_robot);
  return text;
}

std::string ImageOfSlam(const SessionRow& row) {
  std::string text;
  if (!row.mapping) return text;
  for (const auto& [id, submap] : row.mapping->map.submaps) {
    text += fmt::format("submap {} {} {}", id, submap.version, Exactly(submap.T_map_submap));
  }
  for (const auto& [id, node] : row.mapping->map.nodes) {
    text += fmt::format("node {} {}", id, Exactly(PoseWithCovariance{node.T_map_node, node.covariance}));
  }
  return text;
}

std::string ImageOfClosures(const SessionRow& row) {
  std::string text;
  if (!row.mapping) return text;
  for (const auto& [id, closure] : row.mapping->map.loop_closures) {
    text += fmt::format("closure {} {} {} {} {}", id, closure.submap, closure.node, Exactly(closure.T_submap_node),
                        static_cast<int>(closure.state));
  }
  return text;
}

// Without what the optimisation switches off, and where it has the place.
std::string ImageOf(const LinkPointRow& row) {
  const graph::LinkPoint& point = row.link_point.point;
  const bool suspended = point.use == graph::LinkPointUse::kSuspended;
  std::string text = fmt::format("kind {} direction {} tag {} difficulty {} state {} until {} suspended {} forced {}",
                                 static_cast<int>(point.kind), point.direction.value(), point.tag, point.difficulty,
                                 static_cast<int>(point.state), point.state_valid_until.value_or(-1), suspended,
                                 row.link_point.forced);
  for (const graph::Anchor& anchor : point.anchors) {
    text += fmt::format(" anchor {} {}", anchor.map.value(),
                        Exactly(PoseWithCovariance{anchor.T_map_place, anchor.covariance}));
  }
  for (const storage::Evidence& evidence : row.evidence) {
    text += fmt::format(" evidence {} {} {} {}", evidence.map.value(), static_cast<int>(evidence.kind),
                        ToHex(evidence.content.sha256), Exactly(evidence.T_map_robot.value_or(Pose2())));
  }
  return text;
}

std::string ImageOf(const std::vector<storage::ControlPoint>& points) {
  std::string text;
  for (const storage::ControlPoint& point : points) {
    text += fmt::format("{} {} {} {} {};", point.map.value(), point.position.x(), point.position.y(), point.latitude,
                        point.longitude);
  }
  return text;
}

template <typename Key, typename Row>
std::optional<Row> Copy(const std::map<Key, Row>& rows, const Key& key) {
  const auto found = rows.find(key);
  return found == rows.end() ? std::nullopt : std::optional<Row>(found->second);
}

void Put(std::string_view relation, const std::string& key, std::string text, Images& images) {
  images[{std::string(relation), key}] = std::move(text);
}

void KeepMap(const SiteRows& site, const MapId& map, RowsBefore& before) {
  before.maps.emplace(map, Copy(site.maps, map));
  before.places.emplace(map, Copy(site.graph.maps, map));
}

}  // namespace

void KeepBefore(const SiteRows& site, RearrangementRow& row) {
  const storage::StoredRearrangement& stored = row.stored;
  RowsBefore& before = row.before;
  for (const auto& [session, source] : row.sources) KeepMap(site, source, before);
  for (const rearrange::SessionMove& move : stored.moves) {
    KeepMap(site, move.to, before);
    before.sessions.emplace(move.session, Copy(site.sessions, move.session));
  }
  for (const rearrange::SessionCut& cut : stored.cuts) {
    before.sessions.emplace(cut.session, Copy(site.sessions, cut.session));
    before.sessions.emplace(cut.rest, std::nullopt);
  }
  for (const rearrange::MapRedirect& redirect : stored.redirects) {
    KeepMap(site, redirect.from, before);
    KeepMap(site, redirect.to, before);
  }
  for (const auto* ids : {&stored.changed_link_points, &stored.removed_link_points}) {
    for (const LinkPointId& id : *ids) before.link_points.emplace(id, Copy(site.graph.link_points, id));
  }
  before.robot_poses = site.robot_poses;
  before.control_points = site.graph.control_points;
  row.images_before = PresentImages(site, row);
}

Images PresentImages(const SiteRows& site, const RearrangementRow& row) {
  Images images;
  for (const auto& [id, before] : row.before.maps) {
    const auto map = site.maps.find(id);
    Put(storage::image::kMap, id.value(), map == site.maps.end() ? "" : ImageOf(map->second), images);
    Put(storage::image::kLayers, id.value(), map == site.maps.end() ? "" : ImageOfLayers(map->second), images);
  }
  for (const auto& [id, before] : row.before.sessions) {
    const auto found = site.sessions.find(id);
    const SessionRow* session = found == site.sessions.end() || found->second.deleted ? nullptr : &found->second;
    Put(storage::image::kSession, id.value(), session == nullptr ? "" : ImageOf(*session), images);
    Put(storage::image::kSlam, id.value(), session == nullptr ? "" : ImageOfSlam(*session), images);
  }
  for (const rearrange::SessionCut& cut : row.stored.cuts) {
    const auto found = site.sessions.find(cut.session);
    Put(storage::image::kClosures, cut.session.value(),
        found == site.sessions.end() ? "" : ImageOfClosures(found->second), images);
  }
  for (const auto& [id, before] : row.before.link_points) {
    const auto point = site.graph.link_points.find(id);
    Put(storage::image::kLinkPoint, id.value(), point == site.graph.link_points.end() ? "" : ImageOf(point->second),
        images);
  }
  for (const storage::ControlPoint& point : row.before.control_points) {
    for (const rearrange::MapRedirect& redirect : row.stored.redirects) {
      if (redirect.from != point.map) continue;
      Put(storage::image::kControlPoints, "", ImageOf(site.graph.control_points), images);
    }
  }
  return images;
}

}  // namespace enfilade::testing
