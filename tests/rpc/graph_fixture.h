// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <string>
#include <thread>

#include "enfilade/v1/graph_service.grpc.pb.h"
#include "fmt/format.h"
#include "proto/convert/geometry.h"
#include "storage/postgres/graph/graph_store.h"
#include "storage/postgres/graph/link_point_store.h"
#include "storage/postgres/graph/robot_pose_store.h"
#include "storage/postgres/maps/map_store.h"
#include "tests/rpc/server_test.h"

namespace enfilade::testing {

// Three rooms in a row beside map "m" (the root): m - b - c, and "far" joined to nothing. Doors are 5 m along x from
// the frame of the room before, at the origin of the one behind.
class GraphTest : public ServerTest {
 protected:
  void SetUp() override {
    MakeMapNamed("b");
    MakeMapNamed("c");
    MakeMapNamed("far");
    Join("mb", "m", "b");
    Join("bc", "b", "c");
    AwaitGraph([](const v1::Graph& graph) { return graph.maps_size() == 4 && graph.link_points_size() == 2; });
  }

  void MakeMapNamed(const std::string& id) {
    storage::Map map;
    map.site = site_;
    map.id = MapId(id);
    map.display_name = fmt::format("Room {}", id);
    EXPECT_OK(maps_.Create(Soon(), map, ""));
  }

  storage::StoredLinkPoint Join(const std::string& id, const std::string& from, const std::string& to,
                                const Pose2& T_from_place = {5, 0, 0}, const Pose2& T_to_place = {}) {
    storage::StoredLinkPoint link_point;
    link_point.site = site_;
    link_point.point.id = LinkPointId(id);
    link_point.point.anchors = {{MapId(from), T_from_place, graph::DefaultAnchorCovariance()},
                                {MapId(to), T_to_place, graph::DefaultAnchorCovariance()}};
    auto made = link_points_.Create(Soon(), link_point, "");
    EXPECT_OK(made);
    return made.ok() ? *made : link_point;
  }

  v1::GetGlobalPoseRequest At(const std::string& map, const Pose2& pose) const {
    v1::GetGlobalPoseRequest request;
    request.mutable_map_pose()->set_map(fmt::format("sites/s/maps/{}", map));
    *request.mutable_map_pose()->mutable_pose_map_robot() =
        convert::ToProto(PoseWithCovariance{pose, graph::DefaultTransformCovariance()});
    return request;
  }

  v1::Graph GetGraph() const {
    v1::GetGraphRequest request;
    request.set_site("sites/s");
    auto response = Call(&v1::GraphService::Stub::GetGraph, request);
    EXPECT_OK(response);
    return response.ok() ? response->graph() : v1::Graph();
  }

  // Until the server has heard of a version for which `done` holds.
  template <typename Done>
  v1::Graph AwaitGraph(const Done& done) const {
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(30);
    while (true) {
      v1::Graph graph = GetGraph();
      if (done(graph)) return graph;
      if (std::chrono::steady_clock::now() > until) {
        ADD_FAILURE() << "waited in vain; version " << graph.graph_version();
        return graph;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  }
  // Until the graph as it is now in the store has a solution. Edits go past the server: it may still answer from a
  // version, also a solved one, before the last of them.
  v1::Graph AwaitSolution() const {
    const absl::StatusOr<std::int64_t> version = graph_store_.GetVersion(Soon(), site_);
    EXPECT_OK(version);
    return AwaitGraph([&version](const v1::Graph& graph) {
      return graph.graph_version() >= version.value_or(0) && graph.solution_version() == graph.graph_version();
    });
  }

  void Report(const std::string& map, const Pose2& pose, TimeNs time) {
    storage::RobotPose report;
    report.site = site_;
    report.robot = RobotId("r");
    report.map = MapId(map);
    report.T_map_robot = {pose, graph::DefaultTransformCovariance()};
    report.time = time;
    EXPECT_OK(robot_poses_.Report(Soon(), report));
  }

  const SiteId site_{"s"};
  const storage::postgres::MapStore maps_{*pool_};
  const storage::postgres::LinkPointStore link_points_{*pool_};
  const storage::postgres::GraphStore graph_store_{*pool_};
  const storage::postgres::RobotPoseStore robot_poses_{*pool_};
};

}  // namespace enfilade::testing
