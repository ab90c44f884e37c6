// SPDX-License-Identifier: Apache-2.0
// Commands for graph, poses and routes: what they ask for, and what they print.
#include <algorithm>

#include "tests/unit/client/cli/server_commands_fixture.h"

namespace enfilade::cli {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

class GraphCommandsTest : public ServerCommandsTest {
 protected:
  GraphCommandsTest() {
    server_.graph.get_graph = [](const v1::GetGraphRequest& request, v1::GetGraphResponse& response) {
      v1::Graph& graph = *response.mutable_graph();
      graph.set_graph_version(request.graph_version() == 0 ? 9 : request.graph_version());
      for (const std::string map : {"h", "l", "x"}) graph.add_maps()->set_map("sites/s/maps/" + map);
      graph.mutable_maps(1)->mutable_pose_world_map()->mutable_pose()->set_x(8.0);
      graph.mutable_maps(1)->set_optimized(true);
      v1::GraphLinkPoint& point = *graph.add_link_points();
      point.set_link_point("sites/s/linkPoints/door");
      point.add_maps("sites/s/maps/h");
      return grpc::Status::OK;
    };
  }
};

TEST_F(GraphCommandsTest, ShowsMapsThatAreNotJoinedAndCandidates) {
  ASSERT_OK(Run({"graph", "show", "--version", "4"}, false));
  EXPECT_THAT(printed_, HasSubstr("graph version 4: 3 maps, 1 link points; root -"));
  EXPECT_THAT(printed_, HasSubstr("8.000 0.000 0.0000  optimised"));
  EXPECT_THAT(printed_, HasSubstr("not joined"));
  EXPECT_THAT(printed_, HasSubstr("door        h     not joined     candidate"));
  ASSERT_OK(Run({"graph", "show"}));
  EXPECT_EQ(Printed()["graph_version"], 9);
  EXPECT_FALSE(Printed()["maps"][0].contains("pose_world_map"));
}

// The version of the first page is gone twice.
TEST_F(GraphCommandsTest, ReadsTheGraphPageByPageAndBeginsAgain) {
  int gone = 2;
  server_.graph.get_graph = [&](const v1::GetGraphRequest& request, v1::GetGraphResponse& response) {
    EXPECT_EQ(request.page_size(), 1000);
    EXPECT_TRUE(request.with_edges());
    v1::Graph& graph = *response.mutable_graph();
    graph.set_graph_version(9);
    graph.set_root_map("sites/s/maps/h");
    if (request.page_token().empty()) {
      graph.add_maps()->set_map("sites/s/maps/h");
      response.set_next_page_token("links");
    } else if (gone-- > 0) {
      return grpc::Status(grpc::StatusCode::ABORTED, "gone");
    } else if (request.page_token() == "links") {
      graph.add_link_points()->set_link_point("sites/s/linkPoints/door");
      response.set_next_page_token("edges");
    } else {
      graph.add_edges()->set_map("sites/s/maps/h");
    }
    return grpc::Status::OK;
  };
  ASSERT_OK(Run({"graph", "show", "--edges"}));
  EXPECT_EQ(Printed()["maps"].size(), 1U);
  EXPECT_EQ(Printed()["link_points"].size(), 1U);
  EXPECT_EQ(Printed()["edges"].size(), 1U);
  EXPECT_EQ(Printed()["root_map"], "sites/s/maps/h");
  gone = 100;
  EXPECT_CODE(Run({"graph", "show", "--edges"}), absl::StatusCode::kAborted);
}

TEST_F(GraphCommandsTest, VersionsNameCausesAndWhatOptimisationFound) {
  server_.graph.list_versions = [](const v1::ListGraphVersionsRequest& request,
                                   v1::ListGraphVersionsResponse& response) {
    for (int i = 0; i < std::min(request.page_size(), 3); ++i) {
      v1::GraphVersion& version = *response.add_graph_versions();
      version.set_graph_version(10 - i);
      version.set_cause(v1::GraphVersion::CAUSE_OPTIMIZED);
      version.set_chi2_before(12.5);
      version.add_switched_off("sites/s/linkPoints/door");
    }
    return grpc::Status::OK;
  };
  ASSERT_OK(Run({"graph", "versions", "--count", "2"}));
  EXPECT_EQ(Printed().size(), 2U);
  EXPECT_EQ(Printed()[0]["cause"], "optimized");
  ASSERT_OK(Run({"graph", "versions"}, false));
  EXPECT_THAT(printed_, HasSubstr("chi2 12.5 -> 0, 1 switched off"));
}

TEST_F(GraphCommandsTest, OptimisingReportsWhatWasSwitchedOff) {
  server_.graph.optimize = [](const v1::OptimizeGraphRequest&, v1::OptimizeGraphResponse& response) {
    response.set_maps(3);
    response.set_converged(false);
    response.add_switched_off()->set_link_point("sites/s/linkPoints/door");
    response.add_disconnected_maps("sites/s/maps/x");
    return grpc::Status::OK;
  };
  ASSERT_OK(Run({"graph", "optimize"}, false));
  EXPECT_THAT(printed_, HasSubstr("3 maps placed"));
  EXPECT_THAT(printed_, HasSubstr("not converged"));
  EXPECT_THAT(printed_, HasSubstr("switched off door"));
  EXPECT_THAT(printed_, HasSubstr("not joined to the root: x"));
}

TEST_F(GraphCommandsTest, ThePlotOfAMapWithoutFilesIsItsAxes) {
  server_.maps.get_map = [](const v1::GetMapRequest& request, v1::GetMapResponse& response) {
    response.mutable_map()->set_name(request.name());
    return grpc::Status::OK;
  };
  server_.maps.export_map = [](const v1::ExportMapRequest&, auto&) {
    return grpc::Status(grpc::StatusCode::FAILED_PRECONDITION, "no revision");
  };
  server_.sessions.list = [](const v1::ListSessionsRequest&, auto&) { return grpc::Status::OK; };
  const std::string svg = directory_.path() / "g.svg";
  ASSERT_OK(Run({"graph", "plot", "-o", svg}));
  EXPECT_EQ(Printed()["maps"], 1) << "only one map has a pose in the world";
  EXPECT_EQ(Printed()["grids"], 0);
  EXPECT_THAT(Content(svg), HasSubstr("<svg"));
  server_.maps.export_map = [](const v1::ExportMapRequest&, auto&) {
    return grpc::Status(grpc::StatusCode::INTERNAL, "broken");
  };
  EXPECT_CODE(Run({"graph", "plot", "-o", svg}), absl::StatusCode::kInternal);
}

TEST_F(GraphCommandsTest, AGlobalPoseComesFromARobotOrAPoseInAMap) {
  v1::GetGlobalPoseRequest asked;
  server_.graph.get_global_pose = [&](const v1::GetGlobalPoseRequest& request, v1::GetGlobalPoseResponse& response) {
    asked = request;
    v1::GlobalPose& pose = *response.mutable_global_pose();
    pose.set_search_radius_m(12.5);
    if (!request.robot().empty()) pose.set_robot(request.robot());
    if (!request.robot().empty()) return grpc::Status::OK;
    v1::PoseWithCovariance& world = *pose.mutable_pose_world_robot();
    world.mutable_pose()->set_x(2.0);
    for (const double value : {0.04, 0.0, 0.0, 0.0, 0.09, 0.0, 0.0, 0.0, 0.01}) world.add_covariance(value);
    pose.add_hops()->set_link_point("sites/s/linkPoints/door");
    return grpc::Status::OK;
  };
  ASSERT_OK(Run({"pose", "global", "--at", "Lab,1,2,0.5"}, false));
  EXPECT_EQ(asked.map_pose().map(), "sites/s/maps/l");
  EXPECT_THAT(printed_, HasSubstr("x 2.000 m, y 0.000 m, yaw 0.0000 rad  (sigma 0.200 m, 0.300 m, 0.1000 rad)"));
  EXPECT_THAT(printed_, HasSubstr("through door"));
  EXPECT_THAT(printed_, HasSubstr("search radius 12.50 m"));
  ASSERT_OK(Run({"pose", "global", "--robot", "r1"}, false));
  EXPECT_EQ(asked.robot(), "sites/s/robots/r1");
  EXPECT_THAT(printed_, HasSubstr("neither link points nor a plan join its map to the root"));
}

TEST_F(GraphCommandsTest, WatchedPosesAreOneLineEach) {
  server_.graph.watch_global_poses = [](const v1::WatchGlobalPosesRequest& request,
                                        grpc::ServerWriter<v1::WatchGlobalPosesResponse>& writer) {
    EXPECT_EQ(request.robots(0), "sites/s/robots/r1");
    EXPECT_EQ(request.rate_hz(), 5.0);
    v1::WatchGlobalPosesResponse response;
    for (const char* robot : {"r1", "r2"}) response.add_global_poses()->set_robot(robot);
    writer.Write(response);
    return grpc::Status::OK;
  };
  ASSERT_OK(Run({"pose", "watch", "--robot", "r1", "--rate", "5"}));
  EXPECT_EQ(std::count(printed_.begin(), printed_.end(), '\n'), 2);
  EXPECT_EQ(json::parse(printed_.substr(0, printed_.find('\n')))["robot"], "r1");
}

TEST_F(GraphCommandsTest, RoutesAreAskedForByCost) {
  v1::FindRoutesRequest asked;
  bool any = true;
  server_.graph.find_routes = [&](const v1::FindRoutesRequest& request, v1::FindRoutesResponse& response) {
    asked = request;
    response.set_geojson("{}");
    if (!any) return grpc::Status::OK;
    v1::Route& route = *response.add_routes();
    route.set_length_m(10.0);
    route.add_legs()->set_exit("sites/s/linkPoints/door");
    route.add_legs()->set_map("sites/s/maps/l");
    return grpc::Status::OK;
  };
  const std::pair<std::string, v1::PathCost> costs[] = {
      {"distance", v1::PATH_COST_DISTANCE}, {"hops", v1::PATH_COST_HOPS}, {"uncertainty", v1::PATH_COST_UNCERTAINTY}};
  for (const auto& [name, cost] : costs) {
    ASSERT_OK(Run({"route", "Hall,1,2", "Lab,3,4", "--cost", name, "--alternatives", "3"}));
    EXPECT_EQ(asked.cost(), cost);
  }
  EXPECT_EQ(asked.start_map(), "sites/s/maps/h");
  EXPECT_EQ(asked.pose_map_goal().y(), 4.0);
  EXPECT_EQ(asked.max_routes(), 3);
  EXPECT_EQ(Printed()["routes"][0]["legs"].size(), 2U);
  ASSERT_OK(Run({"route", "Hall,1,2", "Lab,3,4"}, false));
  EXPECT_THAT(printed_, HasSubstr("door"));
  EXPECT_THAT(printed_, HasSubstr("goal"));
  ASSERT_OK(Run({"route", "Hall,1,2", "Lab,3,4", "--geojson"}));
  EXPECT_EQ(printed_, "{}\n");
  any = false;
  ASSERT_OK(Run({"route", "Hall,1,2", "Lab,3,4"}, false));
  EXPECT_THAT(printed_, HasSubstr("no route"));
}

}  // namespace
}  // namespace enfilade::cli
