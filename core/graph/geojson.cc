// SPDX-License-Identifier: Apache-2.0
#include "core/graph/geojson.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/base/error.h"

namespace enfilade::graph {
namespace {

using Json = nlohmann::ordered_json;

const char* NameOf(LinkPointKind kind) {
  switch (kind) {
    case LinkPointKind::kDoor:
      return "door";
    case LinkPointKind::kLift:
      return "lift";
    case LinkPointKind::kStairs:
      return "stairs";
    case LinkPointKind::kRamp:
      return "ramp";
    case LinkPointKind::kOpening:
      return "opening";
  }
  return "unknown";
}

const char* NameOf(PassageState state) {
  switch (state) {
    case PassageState::kOpen:
      return "open";
    case PassageState::kClosed:
      return "closed";
    case PassageState::kBlocked:
      return "blocked";
  }
  return "unknown";
}

const char* NameOf(LinkPointUse use) {
  switch (use) {
    case LinkPointUse::kUsed:
      return "used";
    case LinkPointUse::kSwitchedOff:
      return "switched_off";
    case LinkPointUse::kSuspended:
      return "suspended";
  }
  return "unknown";
}

class Writer {
 public:
  Writer(const WorldPoses& poses, const geo::Georeference* georeference, std::int64_t graph_version)
      : poses_(poses), georeference_(georeference) {
    collection_["type"] = "FeatureCollection";
    if (georeference_ == nullptr) collection_["frame"] = "world_metres";
    collection_["graph_version"] = graph_version;
    collection_["features"] = Json::array();
  }

  // The pose of the map's frame; null if the map is not connected to the world.
  const PoseWithCovariance* FindWorld(const MapId& map) {
    const auto [found, is_new] = T_world_maps_.try_emplace(map);
    if (is_new) {
      const auto pose = poses_.Find(map);
      if (pose.ok() && pose->has_value()) found->second = (*pose)->T_world_robot;
    }
    return found->second.has_value() ? &*found->second : nullptr;
  }

  Json Position(const Eigen::Vector2d& p_world) const {
    if (georeference_ == nullptr) return {p_world.x(), p_world.y()};
    const geo::LonLat place = georeference_->ToLonLat(p_world);
    return {place.longitude, place.latitude};
  }

  Json Point(const Eigen::Vector2d& p_world) const { return {{"type", "Point"}, {"coordinates", Position(p_world)}}; }

  Json Line(const std::vector<Eigen::Vector2d>& points) const {
    Json line = {{"type", "LineString"}, {"coordinates", Json::array()}};
    for (const Eigen::Vector2d& point : points) line["coordinates"].push_back(Position(point));
    return line;
  }

  // Counter-clockwise, as the RFC requires.
  Json Polygon(const Pose2& T_world_map, const std::vector<Eigen::Vector2d>& outline) const {
    double area = 0.0;
    for (std::size_t i = 0; i < outline.size(); ++i) {
      const Eigen::Vector2d& next = outline[(i + 1) % outline.size()];
      area += outline[i].x() * next.y() - outline[i].y() * next.x();
    }
    Json ring = Json::array();
    for (std::size_t i = 0; i <= outline.size(); ++i) {
      const std::size_t corner = i % outline.size();
      ring.push_back(Position(T_world_map * outline[area < 0.0 ? (outline.size() - corner) % outline.size() : corner]));
    }
    return {{"type", "Polygon"}, {"coordinates", Json::array({std::move(ring)})}};
  }

  void Add(std::string id, Json geometry, Json properties) {
    collection_["features"].push_back({{"type", "Feature"},
                                       {"id", std::move(id)},
                                       {"geometry", std::move(geometry)},
                                       {"properties", std::move(properties)}});
  }

  // Replaces bytes that are not UTF-8, which JSON cannot hold.
  std::string Text() const { return collection_.dump(-1, ' ', false, Json::error_handler_t::replace); }

 private:
  const WorldPoses& poses_;
  const geo::Georeference* georeference_;
  Json collection_;
  std::unordered_map<MapId, std::optional<PoseWithCovariance>> T_world_maps_;
};

double PositionDeviation(const PoseWithCovariance& pose) {
  return std::sqrt(pose.covariance(0, 0) + pose.covariance(1, 1));
}

void AddMap(const MapInGraph& map, Writer& writer) {
  Json properties = {
      {"kind", "map"}, {"map", map.id.value()}, {"display_name", map.display_name}, {"level", map.level}};
  Json geometry;
  if (const PoseWithCovariance* T_world_map = writer.FindWorld(map.id)) {
    properties["yaw_rad"] = T_world_map->pose.yaw;
    properties["position_sigma_m"] = PositionDeviation(*T_world_map);
    geometry = map.outline.empty() ? writer.Point(T_world_map->pose.translation())
                                   : writer.Polygon(T_world_map->pose, map.outline);
  }
  writer.Add("maps/" + map.id.value(), std::move(geometry), std::move(properties));
}

void AddLinkPoint(const WorldPoses& poses, const LinkPoint& link_point, Writer& writer) {
  Json maps = Json::array();
  for (const Anchor& anchor : link_point.anchors) maps.push_back(anchor.map.value());
  Json properties = {{"kind", link_point.is_candidate() ? "link_point_candidate" : "link_point"},
                     {"link_point", link_point.id.value()},
                     {"passage", NameOf(link_point.kind)},
                     {"tag", link_point.tag},
                     {"state", NameOf(link_point.state)},
                     {"use", NameOf(link_point.use)},
                     {"difficulty", link_point.difficulty},
                     {"maps", std::move(maps)}};
  Json geometry;
  if (const auto T_world_place = FindInWorld(poses, link_point)) {
    properties["yaw_rad"] = T_world_place->pose.yaw;
    properties["position_sigma_m"] = PositionDeviation(*T_world_place);
    geometry = writer.Point(T_world_place->pose.translation());
  }
  writer.Add("linkPoints/" + link_point.id.value(), std::move(geometry), std::move(properties));
}

void AddEdges(const GraphSnapshot& graph, const GraphSnapshot::MapNode& node, Writer& writer) {
  const MapId& map = node.map->id;
  const PoseWithCovariance* T_world_map = writer.FindWorld(map);
  for (std::size_t i = 0; i < node.doorways.size(); ++i) {
    for (std::size_t j = i + 1; j < node.doorways.size(); ++j) {
      const Eigen::Vector2d a(node.doorways[i].x, node.doorways[i].y);
      const Eigen::Vector2d b(node.doorways[j].x, node.doorways[j].y);
      const std::string& id_a = graph.link_point_node(node.doorways[i].link_point).link_point->id.value();
      const std::string& id_b = graph.link_point_node(node.doorways[j].link_point).link_point->id.value();
      Json properties = {
          {"kind", "edge"}, {"map", map.value()}, {"link_points", {id_a, id_b}}, {"length_m", (b - a).norm()}};
      writer.Add(fmt::format("maps/{}/edges/{}/{}", map.value(), id_a, id_b),
                 T_world_map == nullptr ? Json() : writer.Line({T_world_map->pose * a, T_world_map->pose * b}),
                 std::move(properties));
    }
  }
}

void AddTrack(const Track& track, Writer& writer) {
  Json geometry;
  if (const PoseWithCovariance* T_world_map = writer.FindWorld(track.map)) {
    std::vector<Eigen::Vector2d> p_world;
    p_world.reserve(track.p_map.size());
    for (const Eigen::Vector2d& p_map : track.p_map) p_world.push_back(T_world_map->pose * p_map);
    geometry = writer.Line(p_world);
  }
  writer.Add("sessions/" + track.session.value() + "/track", std::move(geometry),
             {{"kind", "track"},
              {"session", track.session.value()},
              {"robot", track.robot.value()},
              {"map", track.map.value()}});
}

}  // namespace

std::string GraphToGeoJson(const WorldPoses& poses, const geo::Georeference* georeference, bool with_edges,
                           const std::vector<Track>& tracks) {
  const GraphSnapshot& graph = poses.graph();
  Writer writer(poses, georeference, graph.version());
  const std::vector<const MapInGraph*> maps = graph.ListMaps();
  for (const MapInGraph* map : maps) AddMap(*map, writer);
  for (const LinkPoint* link_point : graph.ListLinkPoints()) AddLinkPoint(poses, *link_point, writer);
  if (with_edges) {
    for (const MapInGraph* map : maps) AddEdges(graph, graph.map_node(graph.MapSlot(map->id)), writer);
  }
  for (const Track& track : tracks) AddTrack(track, writer);
  return writer.Text();
}

std::string RoutesToGeoJson(const Routes& routes, const WorldPoses& poses, const geo::Georeference* georeference) {
  Writer writer(poses, georeference, routes.graph_version);
  for (std::size_t r = 0; r < routes.routes.size(); ++r) {
    for (std::size_t i = 0; i < routes.routes[r].legs.size(); ++i) {
      const RouteLeg& leg = routes.routes[r].legs[i];
      Json properties = {{"kind", "route_leg"},     {"route", r},         {"leg", i},
                         {"map", leg.map.value()},  {"level", leg.level}, {"length_m", leg.length_m},
                         {"exit", leg.exit.value()}};
      const PoseWithCovariance* T_world_map = writer.FindWorld(leg.map);
      writer.Add(fmt::format("routes/{}/legs/{}", r, i),
                 T_world_map == nullptr ? Json()
                                        : writer.Line({T_world_map->pose * leg.T_map_begin.translation(),
                                                       T_world_map->pose * leg.T_map_end.translation()}),
                 std::move(properties));
    }
  }
  return writer.Text();
}

}  // namespace enfilade::graph
