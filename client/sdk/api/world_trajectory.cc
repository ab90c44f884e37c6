// SPDX-License-Identifier: Apache-2.0
#include "client/sdk/api/world_trajectory.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <utility>

#include "client/sdk/api/graph.h"
#include "client/sdk/api/paging.h"
#include "client/sdk/api/trajectory.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "enfilade/v1/graph_service.grpc.pb.h"
#include "enfilade/v1/session_service.grpc.pb.h"
#include "proto/convert/record.h"

namespace enfilade::client {
namespace {

constexpr int kReads = 5;

absl::StatusOr<std::vector<MappedPose>> ReadPoses(const Connection& connection, const std::string& session) {
  std::vector<MappedPose> poses;
  const auto take = [&poses](const v1::TrajectoryPose& pose) {
    poses.push_back(
        {pose.time().seconds() * kNsPerSecond + pose.time().nanos(), convert::FromProto(pose.pose_map_robot())});
    return absl::OkStatus();
  };
  ENFILADE_RETURN_IF_ERROR(ExportTrajectory(connection, session, take).status());
  return poses;
}

// `robot`: unset: all robots.
absl::StatusOr<std::vector<MappedStretch>> ReadOnce(const Connection& connection, const v1::Graph& graph,
                                                    const std::optional<std::string>& robot) {
  std::map<std::string, const v1::GraphMap*> maps;
  for (const v1::GraphMap& map : graph.maps()) maps[map.map()] = &map;
  v1::ListSessionsRequest request;
  request.set_parent(graph.site());
  ENFILADE_ASSIGN_OR_RETURN(
      const std::vector<v1::Session> sessions,
      ListAll(connection, &v1::SessionService::Stub::ListSessions, request, &v1::ListSessionsResponse::sessions));
  std::vector<MappedStretch> stretches;
  bool any = false;
  for (const v1::Session& session : sessions) {
    if (robot && session.robot() != *robot) continue;
    any = true;
    MappedStretch stretch{session.name(), session.map(), "", std::nullopt, {}};
    if (const auto map = maps.find(session.map()); map != maps.end()) {
      stretch.map_name = map->second->display_name();
      if (map->second->has_pose_world_map()) {
        stretch.T_world_map = convert::FromProto(map->second->pose_world_map().pose());
      }
    }
    ENFILADE_ASSIGN_OR_RETURN(stretch.poses, ReadPoses(connection, session.name()));
    if (!stretch.poses.empty() || stretch.map.empty()) stretches.push_back(std::move(stretch));
  }
  if (robot && !any) return NotFound("{} has no sessions", *robot);
  const auto begin = [](const MappedStretch& stretch) {
    return stretch.poses.empty() ? TimeNs{0} : stretch.poses.front().time;
  };
  std::stable_sort(stretches.begin(), stretches.end(),
                   [&](const MappedStretch& a, const MappedStretch& b) { return begin(a) < begin(b); });
  return stretches;
}

}  // namespace

absl::StatusOr<std::vector<MappedStretch>> ReadStretches(const Connection& connection, const std::string& robot) {
  const std::string site = robot.substr(0, robot.find("/robots/"));
  ENFILADE_ASSIGN_OR_RETURN(v1::Graph graph, ReadGraph(connection, site));
  for (int i = 0; i < kReads; ++i) {
    ENFILADE_ASSIGN_OR_RETURN(std::vector<MappedStretch> stretches, ReadOnce(connection, graph, robot));
    ENFILADE_ASSIGN_OR_RETURN(v1::Graph after, ReadGraph(connection, site));
    if (after.graph_version() == graph.graph_version()) return stretches;
    graph = std::move(after);
  }
  return absl::AbortedError("the graph of " + site + " keeps changing: try again when the robots are done");
}

absl::StatusOr<std::vector<MappedStretch>> ReadPresentStretches(const Connection& connection, const std::string& site) {
  ENFILADE_ASSIGN_OR_RETURN(const v1::Graph graph, ReadGraph(connection, site));
  return ReadOnce(connection, graph, std::nullopt);
}

WorldTrajectory JoinStretches(const std::vector<MappedStretch>& stretches) {
  WorldTrajectory joined;
  for (const MappedStretch& stretch : stretches) {
    if (!stretch.T_world_map) {
      joined.left_out.push_back(stretch);
      continue;
    }
    for (const MappedPose& pose : stretch.poses) {
      joined.poses.push_back({pose.time, *stretch.T_world_map * pose.T_map_robot});
    }
  }
  std::stable_sort(joined.poses.begin(), joined.poses.end(),
                   [](const WorldPose& a, const WorldPose& b) { return a.time < b.time; });
  const auto same_time = [](const WorldPose& a, const WorldPose& b) { return a.time == b.time; };
  joined.poses.erase(std::unique(joined.poses.begin(), joined.poses.end(), same_time), joined.poses.end());
  return joined;
}

}  // namespace enfilade::client
