// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/watch/messages.h"

#include <algorithm>
#include <utility>

#include "core/base/version.h"
#include "proto/convert/names.h"
#include "proto/convert/record.h"
#include "server/rpc/graph/get_global_pose.h"
#include "server/rpc/graph/messages.h"

namespace enfilade::server {
namespace {

using convert::NameOf;

// Passes the next items to `add`, as many as the budget allows.
template <typename Item, typename Add>
void Take(const std::vector<Item>& items, std::size_t& written, std::size_t& budget, const Add& add) {
  const std::size_t end = written + std::min(items.size() - written, budget);
  budget -= end - written;
  for (; written < end; ++written) add(items[written]);
}

void FillRobot(const SiteId& site, const SitePoses& poses, const SitePoses::OfRobot& robot, v1::RobotView view,
               v1::RobotState& out) {
  const storage::RobotPose& report = robot.report;
  out.set_robot(NameOf(convert::RobotName{site, report.robot}));
  out.set_map(NameOf(convert::MapName{site, report.map}));
  if (const graph::MapInGraph* const map = poses.graph->graph().FindMap(report.map)) out.set_level(map->level);
  *out.mutable_pose_map_robot() = convert::ToProto(report.T_map_robot.pose);
  if (robot.pose) *out.mutable_pose_world_robot() = convert::ToProto(robot.pose->T_world_robot.pose);
  const Eigen::Matrix3d& covariance = robot.pose ? robot.pose->T_world_robot.covariance : report.T_map_robot.covariance;
  for (const double value : {covariance(0, 0), covariance(0, 1), covariance(1, 1), covariance(2, 2)}) {
    out.add_covariance(static_cast<float>(value));
  }
  *out.mutable_report_time() = convert::ToTimestamp(report.time);
  *out.mutable_receive_time() = convert::ToTimestamp(report.received);
  if (report.session) out.set_session(NameOf(convert::SessionName{site, *report.session}));
  if (view == v1::ROBOT_VIEW_FULL)
    *out.mutable_global_pose() = server::ToProto(report, robot.pose, poses.graph_version());
}

void FillSession(const SiteId& site, const storage::SessionProgress& session, v1::SessionState& out) {
  out.set_session(NameOf(convert::SessionName{site, session.id}));
  out.set_robot(NameOf(convert::RobotName{site, session.robot}));
  if (session.map) out.set_map(NameOf(convert::MapName{site, *session.map}));
  out.set_state(static_cast<v1::Session::State>(session.state));  // the same numbers
  out.set_acknowledged_sequence(session.acknowledged_sequence);
  out.set_mapped_sequence(session.mapped_sequence);
  out.set_error(session.error);
}

void FillRaster(const SiteId& site, const storage::CurrentRevision& revision, v1::MapRasterState& out) {
  out.set_map(NameOf(convert::MapName{site, revision.map}));
  out.set_revision(NameOf(convert::RevisionName{site, revision.map, revision.number}));
  *out.mutable_create_time() = convert::ToTimestamp(revision.create_time);
}

void FillHealth(const SiteHealth& health, v1::SiteHealth& out) {
  out.mutable_mapping_lag()->set_seconds(health.mapping_lag_s);
  out.set_waiting_sessions(static_cast<std::int32_t>(health.waiting_sessions));
  out.set_disconnected_maps(static_cast<std::int32_t>(health.disconnected_maps));
}

std::size_t CountItems(const SiteUpdate& update) {
  return update.removed_maps.size() + update.removed_link_points.size() + update.maps.size() +
         update.link_points.size() + update.revisions.size() + update.removed_sessions.size() + update.sessions.size() +
         update.removed_robots.size() + update.robots.size();
}

}  // namespace

SiteMessages::SiteMessages(SiteId site, v1::RobotView view, SiteUpdate update)
    : site_(std::move(site)), view_(view), update_(std::move(update)), remaining_(CountItems(update_)), first_(true) {}

void SiteMessages::FillGraph(std::size_t& budget, v1::WatchSiteResponse& out) {
  if (!update_.graph_changed ||
      (!first_ && written_.maps == update_.maps.size() && written_.link_points == update_.link_points.size())) {
    return;
  }
  v1::GraphDelta& delta = *out.mutable_graph();
  const SiteGraph& graph = *update_.moment->graph->graph;
  delta.set_graph_version(graph.graph().version());
  delta.set_solution_version(graph.solution_version);
  if (!graph.graph().root().empty()) delta.set_root_map(NameOf(convert::MapName{site_, graph.graph().root()}));
  Take(update_.removed_maps, written_.removed_maps, budget, [&](const MapId& map) {
    delta.add_removed_maps(NameOf(convert::MapName{site_, map}));
  });
  Take(update_.removed_link_points, written_.removed_link_points, budget, [&](const LinkPointId& link_point) {
    delta.add_removed_link_points(NameOf(convert::LinkPointName{site_, link_point}));
  });
  Take(update_.maps, written_.maps, budget,
       [&](const GraphView::Map* map) { Fill(site_, *map->map, map->T_world_map, map->optimized, *delta.add_maps()); });
  Take(update_.link_points, written_.link_points, budget, [&](const GraphView::LinkPoint* link_point) {
    Fill(site_, *link_point->link_point, link_point->T_world_place, *delta.add_link_points());
  });
}

void SiteMessages::Next(v1::WatchSiteResponse& out) {
  std::size_t budget = kMaxItems;
  if (first_ && update_.health) FillHealth(*update_.health, *out.mutable_health());
  FillGraph(budget, out);
  Take(update_.revisions, written_.revisions, budget,
       [&](const storage::CurrentRevision* revision) { FillRaster(site_, *revision, *out.add_rasters()); });
  Take(update_.removed_sessions, written_.removed_sessions, budget, [&](const SessionId& session) {
    out.add_removed_sessions(NameOf(convert::SessionName{site_, session}));
  });
  Take(update_.sessions, written_.sessions, budget,
       [&](const storage::SessionProgress* session) { FillSession(site_, *session, *out.add_sessions()); });
  Take(update_.removed_robots, written_.removed_robots, budget, [&](const RobotId& robot) {
    out.add_removed_robots(NameOf(convert::RobotName{site_, robot}));
  });
  Take(update_.robots, written_.robots, budget, [&](const SitePoses::OfRobot* robot) {
    FillRobot(site_, *update_.moment->poses, *robot, view_, *out.add_robots());
  });
  first_ = false;
  remaining_ -= kMaxItems - budget;
  out.set_more(!done());
}

}  // namespace enfilade::server
