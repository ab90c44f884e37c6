// SPDX-License-Identifier: Apache-2.0
#include "tests/e2e/campus/mapped_state.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <functional>
#include <set>
#include <stdexcept>
#include <thread>
#include <utility>

#include "client/sdk/api/paging.h"
#include "enfilade/v1/graph_service.grpc.pb.h"
#include "enfilade/v1/session_service.grpc.pb.h"
#include "proto/convert/geometry.h"
#include "tests/support/eventually.h"

namespace enfilade::testing {
namespace {

constexpr auto kQuiet = std::chrono::seconds(2);  // no change for so long
constexpr auto kLimit = std::chrono::minutes(10 * kSlowdown);

template <typename T>
T OrThrow(absl::StatusOr<T> result, const char* what) {
  if (!result.ok()) throw std::runtime_error(std::string(what) + ": " + result.status().ToString());
  return *std::move(result);
}

v1::Graph ReadGraph(const client::Connection& connection, const std::string& site) {
  v1::GetGraphRequest request;
  request.set_site(site);
  return OrThrow(connection.Call(&v1::GraphService::Stub::GetGraph, request), "GetGraph").graph();
}

bool AllMapped(const client::Connection& connection, const std::string& site) {
  v1::ListSessionsRequest request;
  request.set_parent(site);
  const auto sessions = OrThrow(client::ListAll(connection, &v1::SessionService::Stub::ListSessions, request,
                                                &v1::ListSessionsResponse::sessions),
                                "ListSessions");
  return std::all_of(sessions.begin(), sessions.end(), [](const v1::Session& session) {
    const bool recorded_only = session.state() == v1::Session::STATE_FINISHED && session.map().empty();
    return recorded_only || session.state() == v1::Session::STATE_MAPPED ||
           session.state() == v1::Session::STATE_FAILED;
  });
}

v1::Graph AwaitQuiet(const client::Connection& connection, const std::string& site) {
  std::int64_t version = -1;
  auto since = std::chrono::steady_clock::now();
  const auto end = since + kLimit;
  while (std::chrono::steady_clock::now() < end) {
    const v1::Graph graph = ReadGraph(connection, site);
    if (graph.graph_version() != version || !AllMapped(connection, site)) {
      version = graph.graph_version();
      since = std::chrono::steady_clock::now();
    }
    if (std::chrono::steady_clock::now() - since > kQuiet) return graph;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  throw std::runtime_error(site + " does not come to rest");
}

MapTransform ReadTransform(const client::Connection& connection, const std::string& a, const std::string& b) {
  v1::TransformPosesRequest request;
  request.set_source_map(b);
  request.set_target_map(a);
  const auto response = OrThrow(connection.Call(&v1::GraphService::Stub::TransformPoses, request), "TransformPoses");
  return {a, b, response.hops_size(),
          OrThrow(convert::FromProto("pose", response.pose_target_source()), "a transform")};
}

std::vector<MapTransform> ReadTransforms(const client::Connection& connection, const v1::Graph& graph) {
  std::set<std::pair<std::string, std::string>> wanted;
  for (const v1::GraphMap& map : graph.maps()) {
    if (map.has_pose_world_map() && map.map() != graph.root_map()) wanted.emplace(graph.root_map(), map.map());
  }
  for (const v1::GraphLinkPoint& point : graph.link_points()) {
    if (point.joins() && point.maps_size() == 2 && point.has_pose_world_place()) {
      wanted.insert(std::minmax(point.maps(0), point.maps(1)));
    }
  }
  std::vector<MapTransform> transforms;
  for (const auto& [a, b] : wanted) transforms.push_back(ReadTransform(connection, a, b));
  return transforms;
}

}  // namespace

int MappedState::candidates() const {
  return static_cast<int>(std::count_if(link_points.begin(), link_points.end(),
                                        [](const MappedLinkPoint& point) { return point.maps.size() == 1; }));
}

int MappedState::components() const {
  std::map<std::string, std::string> parent;
  const std::function<std::string(const std::string&)> top = [&](const std::string& map) {
    const auto up = parent.find(map);
    return up == parent.end() ? map : top(up->second);
  };
  for (const MappedLinkPoint& point : link_points) {
    if (!point.joins) continue;
    for (const std::string& map : point.maps) {
      const std::string a = top(point.maps[0]);
      const std::string b = top(map);
      if (a != b) parent[b] = a;
    }
  }
  std::set<std::string> roots;
  for (const std::string& map : maps) roots.insert(top(map));
  return static_cast<int>(roots.size());
}

MappedState ReadWhenQuiet(const client::Connection& connection, const std::string& site,
                          const std::vector<std::string>& robots) {
  const v1::Graph graph = AwaitQuiet(connection, "sites/" + site);
  MappedState state;
  state.root = graph.root_map();
  for (const v1::GraphMap& map : graph.maps()) {
    state.maps.push_back(map.map());
    if (!map.has_pose_world_map()) continue;
    state.poses.emplace(map.map(), OrThrow(convert::FromProto("pose", map.pose_world_map()), "a map's pose"));
  }
  state.transforms = ReadTransforms(connection, graph);
  for (const v1::GraphLinkPoint& point : graph.link_points()) {
    MappedLinkPoint read{point.link_point(), {point.maps().begin(), point.maps().end()}, point.joins(), std::nullopt};
    if (point.has_pose_world_place()) {
      const v1::Pose2& place = point.pose_world_place().pose();
      read.world = Eigen::Vector2d(place.x(), place.y());
    }
    state.link_points.push_back(std::move(read));
  }
  for (const std::string& robot : robots) {
    state.stretches[robot] =
        OrThrow(client::ReadStretches(connection, graph.site() + "/robots/" + robot), "a robot's way");
  }
  return state;
}

}  // namespace enfilade::testing
