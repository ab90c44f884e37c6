// SPDX-License-Identifier: Apache-2.0
#include <vector>

#include "core/base/sha256.h"
#include "nlohmann/json.hpp"
#include "tests/rpc/graph_fixture.h"
#include "tests/support/pose_matchers.h"

namespace enfilade::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

using Stub = v1::GraphService::Stub;

TEST_F(GraphTest, GetGraphReportsMapsLinkPointsAndEdges) {
  const v1::Graph graph = AwaitSolution();
  EXPECT_EQ(graph.root_map(), "sites/s/maps/m");
  ASSERT_EQ(graph.maps_size(), 4);
  EXPECT_EQ(graph.maps(1).map(), "sites/s/maps/c");
  EXPECT_NEAR(graph.maps(1).pose_world_map().pose().x(), 10.0, 1e-6);
  EXPECT_TRUE(graph.maps(1).optimized());
  EXPECT_EQ(graph.maps(2).map(), "sites/s/maps/far");
  EXPECT_FALSE(graph.maps(2).has_pose_world_map());
  ASSERT_EQ(graph.link_points_size(), 2);
  EXPECT_THAT(graph.link_points(0).maps(), ElementsAre("sites/s/maps/b", "sites/s/maps/c"));
  ASSERT_EQ(graph.edges_size(), 1);
  EXPECT_EQ(graph.edges(0).map(), "sites/s/maps/b");
  EXPECT_EQ(graph.edges(0).length_m(), 5.0);
}

TEST_F(GraphTest, GetGraphGivesAnEarlierVersionThatItHasSeen) {
  const v1::Graph before = AwaitSolution();
  Join("new", "m", "far", {1, 1, 0});
  AwaitGraph([&](const v1::Graph& graph) { return graph.graph_version() > before.graph_version(); });
  v1::GetGraphRequest request;
  request.set_site("sites/s");
  request.set_graph_version(before.graph_version());
  ASSERT_OK_AND_ASSIGN(const v1::GetGraphResponse old, Call(&Stub::GetGraph, request));
  EXPECT_EQ(old.graph().SerializeAsString(), before.SerializeAsString());
  request.set_graph_version(1'000'000);
  EXPECT_STATUS(Call(&Stub::GetGraph, request), absl::StatusCode::kNotFound, HasSubstr("1000000"));
}

TEST_F(GraphTest, AGlobalPoseExplainsItself) {
  ASSERT_OK_AND_ASSIGN(const v1::GetGlobalPoseResponse response, Call(&Stub::GetGlobalPose, At("c", {1, 2, 0.5})));
  const v1::GlobalPose& pose = response.global_pose();
  EXPECT_NEAR(pose.pose_world_robot().pose().x(), 11.0, 1e-6);
  EXPECT_NEAR(pose.pose_world_robot().pose().y(), 2.0, 1e-6);
  EXPECT_GT(pose.graph_version(), 0);
  EXPECT_GT(pose.search_radius_m(), 20.0);
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  const auto add = [&sum](const auto& share) {
    ASSERT_EQ(share.size(), 9);
    for (int i = 0; i < 9; ++i) sum(i / 3, i % 3) += share.Get(i);
  };
  add(pose.base_share());
  add(pose.robot_share());
  for (const v1::PoseHop& hop : pose.hops()) add(hop.share());
  for (int i = 0; i < 9; ++i) EXPECT_NEAR(sum(i / 3, i % 3), pose.pose_world_robot().covariance(i), 1e-12);
}

TEST_F(GraphTest, NoPathIsAnAnswer) {
  ASSERT_OK_AND_ASSIGN(const v1::GetGlobalPoseResponse response, Call(&Stub::GetGlobalPose, At("far", {})));
  EXPECT_FALSE(response.global_pose().has_pose_world_robot());
  EXPECT_GT(response.global_pose().graph_version(), 0);
  v1::TransformPosesRequest request;
  request.set_source_map("sites/s/maps/far");
  request.set_target_map("sites/s/maps/m");
  ASSERT_OK_AND_ASSIGN(const v1::TransformPosesResponse transformed, Call(&Stub::TransformPoses, request));
  EXPECT_FALSE(transformed.has_pose_target_source());
}

TEST_F(GraphTest, TransformsManyPosesAtOnce) {
  v1::TransformPosesRequest request;
  request.set_source_map("sites/s/maps/c");
  request.set_target_map("sites/s/maps/b");
  for (int i = 0; i < 100; ++i) {
    *request.add_poses() =
        convert::ToProto(PoseWithCovariance{{static_cast<double>(i), 1, 0}, Eigen::Matrix3d::Zero()});
  }
  ASSERT_OK_AND_ASSIGN(const v1::TransformPosesResponse response, Call(&Stub::TransformPoses, request));
  ASSERT_EQ(response.poses_size(), 100);
  EXPECT_NEAR(response.poses(42).pose().x(), 47.0, 1e-6);
  EXPECT_EQ(response.hops_size(), 1);
  request.mutable_poses(7)->add_covariance(1.0);
  EXPECT_STATUS(Call(&Stub::TransformPoses, request), absl::StatusCode::kInvalidArgument, HasSubstr("poses[7]"));
}

TEST_F(GraphTest, RoutesRespectDoors) {
  v1::FindRoutesRequest request;
  request.set_start_map("sites/s/maps/m");
  request.mutable_pose_map_start()->set_x(1.0);
  request.set_goal_map("sites/s/maps/c");
  request.mutable_pose_map_goal()->set_x(2.0);
  request.set_with_geojson(true);
  request.set_max_routes(3);
  ASSERT_OK_AND_ASSIGN(const v1::FindRoutesResponse open, Call(&Stub::FindRoutes, request));
  ASSERT_EQ(open.routes_size(), 1);
  EXPECT_NEAR(open.routes(0).length_m(), 11.0, 1e-9);
  ASSERT_EQ(open.routes(0).legs_size(), 3);
  EXPECT_EQ(open.routes(0).legs(0).exit(), "sites/s/linkPoints/mb");
  EXPECT_EQ(nlohmann::json::parse(open.geojson())["features"].size(), 3u);

  ASSERT_OK_AND_ASSIGN(storage::StoredLinkPoint door, link_points_.Get(Soon(), site_, LinkPointId("bc")));
  door.point.state = graph::PassageState::kClosed;
  door.point.state_valid_until = 4'000'000'000 * kNsPerSecond;
  ASSERT_OK(link_points_.Update(Soon(), door));
  const std::int64_t before = open.graph_version();
  AwaitGraph([before](const v1::Graph& graph) { return graph.graph_version() > before; });
  const auto routes = [&]() {
    auto response = Call(&Stub::FindRoutes, request);
    EXPECT_OK(response);
    return response.ok() ? response->routes_size() : -1;
  };
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  while (routes() != 0 && std::chrono::steady_clock::now() < until) {
  }
  EXPECT_EQ(routes(), 0);
  request.mutable_time()->set_seconds(4'000'000'001);
  EXPECT_EQ(routes(), 1);
  // A closed door is no less of a measurement.
  EXPECT_OK(Call(&Stub::GetGlobalPose, At("c", {})));
}

TEST_F(GraphTest, AGeoreferenceMakesGeoJsonOfLongitudeAndLatitude) {
  v1::SetGeoreferenceRequest request;
  request.set_site("sites/s");
  const auto add = [&request](const char* map, double x, double longitude) {
    v1::ControlPoint& point = *request.mutable_georeference()->add_control_points();
    point.set_map(map);
    point.set_x(x);
    point.set_latitude(52.37);
    point.set_longitude(longitude);
  };
  add("sites/s/maps/m", 0.0, 9.7);
  EXPECT_STATUS(Call(&Stub::SetGeoreference, request), absl::StatusCode::kInvalidArgument, HasSubstr("at least two"));
  add("sites/s/maps/c", 3.62, 9.7002);  // 13.62 m east
  ASSERT_OK_AND_ASSIGN(const v1::SetGeoreferenceResponse response, Call(&Stub::SetGeoreference, request));
  EXPECT_NEAR(response.georeference().yaw_east_world(), 0.0, 1e-3);
  EXPECT_LT(response.georeference().rms_m(), 0.02);
  v1::GetGeoreferenceRequest get;
  get.set_site("sites/s");
  ASSERT_OK_AND_ASSIGN(const v1::GetGeoreferenceResponse got, Call(&Stub::GetGeoreference, get));
  EXPECT_EQ(got.georeference().control_points_size(), 2);

  const auto stub = v1::GraphService::NewStub(connection_->channel());
  v1::ExportGraphRequest export_request;
  export_request.set_site("sites/s");
  grpc::ClientContext context;
  const auto stream = stub->ExportGraph(&context, export_request);
  v1::ExportGraphResponse message;
  ASSERT_TRUE(stream->Read(&message));
  ASSERT_EQ(message.manifest().files_size(), 1);
  const v1::FileEntry file = message.manifest().files(0);
  std::string text;
  while (stream->Read(&message)) text += message.chunk().data();
  EXPECT_TRUE(stream->Finish().ok());
  EXPECT_EQ(static_cast<std::int64_t>(text.size()), file.size_bytes());
  EXPECT_EQ(Sha256(text), file.sha256());
  const nlohmann::json json = nlohmann::json::parse(text);
  EXPECT_FALSE(json.contains("frame"));
  EXPECT_NEAR(json["features"][0]["geometry"]["coordinates"][1], 52.37, 1e-3);
}

TEST_F(GraphTest, EveryMethodRefusesAnEmptyMessage) {
  EXPECT_CODE(Call(&Stub::GetGraph, v1::GetGraphRequest()), absl::StatusCode::kInvalidArgument);
  EXPECT_CODE(Call(&Stub::ListGraphVersions, v1::ListGraphVersionsRequest()), absl::StatusCode::kInvalidArgument);
  EXPECT_CODE(Call(&Stub::ListPlacedMaps, v1::ListPlacedMapsRequest()), absl::StatusCode::kInvalidArgument);
  EXPECT_CODE(Call(&Stub::OptimizeGraph, v1::OptimizeGraphRequest()), absl::StatusCode::kInvalidArgument);
  EXPECT_CODE(Call(&Stub::GetGlobalPose, v1::GetGlobalPoseRequest()), absl::StatusCode::kInvalidArgument);
  EXPECT_CODE(Call(&Stub::TransformPoses, v1::TransformPosesRequest()), absl::StatusCode::kInvalidArgument);
  EXPECT_CODE(Call(&Stub::FindRoutes, v1::FindRoutesRequest()), absl::StatusCode::kInvalidArgument);
  EXPECT_CODE(Call(&Stub::SetGeoreference, v1::SetGeoreferenceRequest()), absl::StatusCode::kInvalidArgument);
  EXPECT_CODE(Call(&Stub::GetGeoreference, v1::GetGeoreferenceRequest()), absl::StatusCode::kInvalidArgument);
  const auto stub = v1::GraphService::NewStub(connection_->channel());
  {
    grpc::ClientContext context;
    v1::WatchGlobalPosesResponse message;
    const auto stream = stub->WatchGlobalPoses(&context, v1::WatchGlobalPosesRequest());
    EXPECT_FALSE(stream->Read(&message));
    EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  }
  grpc::ClientContext context;
  v1::ExportGraphResponse message;
  const auto stream = stub->ExportGraph(&context, v1::ExportGraphRequest());
  EXPECT_FALSE(stream->Read(&message));
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::INVALID_ARGUMENT);
}

TEST_F(GraphTest, RefusesWhatMakesNoSense) {
  v1::FindRoutesRequest request;
  request.set_start_map("sites/s/maps/m");
  request.mutable_pose_map_start();
  request.set_goal_map("sites/s/maps/c");
  request.mutable_pose_map_goal();
  request.set_cost(static_cast<v1::PathCost>(99));
  EXPECT_STATUS(Call(&Stub::FindRoutes, request), absl::StatusCode::kInvalidArgument, HasSubstr("99"));
  request.set_cost(v1::PATH_COST_HOPS);
  request.set_max_routes(1000);
  EXPECT_CODE(Call(&Stub::FindRoutes, request), absl::StatusCode::kInvalidArgument);
  request.set_max_routes(1);
  request.mutable_pose_map_goal()->set_x(std::nan(""));
  EXPECT_CODE(Call(&Stub::FindRoutes, request), absl::StatusCode::kInvalidArgument);
  v1::GetGraphRequest nowhere;
  nowhere.set_site("sites/nowhere");
  EXPECT_CODE(Call(&Stub::GetGraph, nowhere), absl::StatusCode::kNotFound);
  EXPECT_CODE(Call(&Stub::GetGlobalPose, At("nowhere", {})), absl::StatusCode::kNotFound);
}
}  // namespace
}  // namespace enfilade::testing
