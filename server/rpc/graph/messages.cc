// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/graph/messages.h"

#include <limits>

#include "core/graph/search_radius.h"
#include "proto/convert/geometry.h"
#include "proto/convert/names.h"
#include "proto/convert/record.h"

namespace enfilade::server {
namespace {

std::string MapNameOf(const SiteId& site, const MapId& map) { return convert::NameOf(convert::MapName{site, map}); }
std::string LinkPointNameOf(const SiteId& site, const LinkPointId& id) {
  return convert::NameOf(convert::LinkPointName{site, id});
}

void FillMap(const SiteId& site, const SiteGraph& graph, const graph::MapInGraph& map, v1::GraphMap& out) {
  const auto pose = graph.poses.Find(map.id);
  if (!pose.ok() || !pose->has_value()) return Fill(site, map, std::nullopt, /*optimized=*/false, out);
  Fill(site, map, (*pose)->T_world_robot, (*pose)->solution_version.has_value() && (*pose)->hops.empty(), out);
}

void FillEdge(const SiteId& site, const GraphEdge& edge, v1::GraphEdge& out) {
  out.set_map(MapNameOf(site, edge.map->id));
  out.set_link_point_a(LinkPointNameOf(site, edge.a->id));
  out.set_link_point_b(LinkPointNameOf(site, edge.b->id));
  out.set_length_m(edge.length);
}

}  // namespace

void Fill(const SiteId& site, const graph::MapInGraph& map, const std::optional<PoseWithCovariance>& T_world_map,
          bool optimized, v1::GraphMap& out) {
  out.set_map(MapNameOf(site, map.id));
  out.set_display_name(map.display_name);
  out.set_level(map.level);
  if (T_world_map) convert::ToProto(*T_world_map, *out.mutable_pose_world_map());
  out.set_optimized(optimized);
}

void Fill(const SiteId& site, const graph::LinkPoint& link_point,
          const std::optional<PoseWithCovariance>& T_world_place, v1::GraphLinkPoint& out) {
  out.set_link_point(LinkPointNameOf(site, link_point.id));
  for (const graph::Anchor& anchor : link_point.anchors) out.add_maps(MapNameOf(site, anchor.map));
  if (T_world_place) convert::ToProto(*T_world_place, *out.mutable_pose_world_place());
  out.set_joins(!link_point.is_candidate() && link_point.use == graph::LinkPointUse::kUsed);
  // The same numbers.
  out.set_kind(static_cast<v1::LinkPoint::Kind>(link_point.kind));
  out.set_use(static_cast<v1::LinkPoint::Use>(link_point.use));
  out.set_state(static_cast<v1::LinkPoint::State>(link_point.state));
}

v1::Graph ToProto(const SiteId& site, const SiteGraph& graph, const GraphPage& page) {
  v1::Graph out;
  out.set_site(NameOf(site));
  out.set_graph_version(graph.graph().version());
  if (!graph.graph().root().empty()) out.set_root_map(MapNameOf(site, graph.graph().root()));
  out.set_solution_version(graph.solution_version);
  for (const graph::MapInGraph* map : page.maps) FillMap(site, graph, *map, *out.add_maps());
  for (const graph::LinkPoint* link_point : page.link_points) {
    Fill(site, *link_point, graph::FindInWorld(graph.poses, *link_point), *out.add_link_points());
  }
  for (const GraphEdge& edge : page.edges) FillEdge(site, edge, *out.add_edges());
  return out;
}

v1::Graph ToProto(const SiteId& site, const SiteGraph& graph) {
  return ToProto(site, graph, ListPage(graph, {}, std::numeric_limits<std::size_t>::max(), /*with_edges=*/true));
}

v1::GraphVersion ToProto(const SiteId& site, const storage::GraphVersion& version) {
  v1::GraphVersion out;
  out.set_graph_version(version.version);
  out.set_cause(static_cast<v1::GraphVersion::Cause>(version.cause));  // the same numbers
  out.set_resource(version.resource);
  out.set_actor(version.actor);
  *out.mutable_create_time() = convert::ToTimestamp(version.create_time);
  if (!version.optimization.has_value()) return out;
  out.set_chi2_before(version.optimization->chi2_before);
  out.set_chi2_after(version.optimization->chi2_after);
  for (const LinkPointId& id : version.optimization->switched_off) out.add_switched_off(LinkPointNameOf(site, id));
  return out;
}

v1::PoseHop ToProto(const SiteId& site, const graph::PoseHop& hop) {
  v1::PoseHop out;
  out.set_link_point(LinkPointNameOf(site, hop.link_point));
  out.set_from_map(MapNameOf(site, hop.from));
  out.set_to_map(MapNameOf(site, hop.to));
  *out.mutable_pose_from_to() = convert::ToProto(hop.T_from_to);
  convert::SetMatrix(hop.share, out.mutable_share());
  return out;
}

void Fill(const SiteId& site, const graph::GlobalPose& pose, v1::GlobalPose& out) {
  *out.mutable_pose_world_robot() = convert::ToProto(pose.T_world_robot);
  out.set_graph_version(pose.graph_version);
  out.set_base_map(MapNameOf(site, pose.base_map));
  *out.mutable_pose_world_base() = convert::ToProto(pose.T_world_base);
  out.set_solution_version(pose.solution_version.value_or(0));
  convert::SetMatrix(pose.base_share, out.mutable_base_share());
  for (const graph::PoseHop& hop : pose.hops) *out.add_hops() = ToProto(site, hop);
  convert::SetMatrix(pose.robot_share, out.mutable_robot_share());
  out.set_search_radius_m(graph::SearchRadius(pose.T_world_robot.covariance));
  for (const PriorMapId& plan : pose.plans) out.add_prior_maps(NameOf(site, plan));
  for (const graph::PlanHop& hop : pose.plan_hops) {
    v1::PriorHop& message = *out.add_prior_hops();
    message.set_prior_map(NameOf(site, hop.plan));
    if (hop.wall >= 0) message.set_wall(hop.wall);
    message.set_shaft(hop.shaft);
    convert::SetMatrix(hop.share, message.mutable_share());
  }
}

v1::Route ToProto(const SiteId& site, const graph::Route& route) {
  v1::Route out;
  out.set_length_m(route.length_m);
  out.set_cost(route.cost);
  for (const graph::RouteLeg& leg : route.legs) {
    v1::RouteLeg& message = *out.add_legs();
    message.set_map(MapNameOf(site, leg.map));
    message.set_level(leg.level);
    *message.mutable_pose_map_begin() = enfilade::convert::ToProto(leg.T_map_begin);
    *message.mutable_pose_map_end() = enfilade::convert::ToProto(leg.T_map_end);
    message.set_length_m(leg.length_m);
    if (!leg.exit.empty()) message.set_exit(LinkPointNameOf(site, leg.exit));
  }
  return out;
}

v1::Georeference ToProto(const SiteId& site, const SiteGraph& graph, const geo::GeoreferenceFit& fit,
                         const std::vector<storage::ControlPoint>& points) {
  v1::Georeference out;
  for (std::size_t i = 0; i < points.size(); ++i) {
    v1::ControlPoint& point = *out.add_control_points();
    point.set_map(MapNameOf(site, points[i].map));
    point.set_x(points[i].position.x());
    point.set_y(points[i].position.y());
    point.set_latitude(points[i].latitude);
    point.set_longitude(points[i].longitude);
    point.set_residual_m(fit.residual_m[i]);
  }
  out.set_rms_m(fit.rms_m);
  out.set_yaw_east_world(fit.georeference.yaw());
  out.set_best_scale(fit.best_scale);
  out.set_graph_version(graph.graph().version());
  return out;
}

}  // namespace enfilade::server
