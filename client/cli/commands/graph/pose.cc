// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <iostream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "client/cli/commands/commands.h"
#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "enfilade/v1/graph_service.grpc.pb.h"
#include "proto/convert/record.h"

namespace enfilade::cli {
namespace {

struct PoseCommandOptions {
  std::string robot;
  std::string at;
  bool walls = false;
  double rate_hz = 1.0;
  std::string from;
  std::string to;
  std::string cost = "distance";
  int alternatives = 1;
  bool geojson = false;
};

std::string FormatPose(const v1::PoseWithCovariance& pose) {
  std::string words =
      fmt::format("x {:.3f} m, y {:.3f} m, yaw {:.4f} rad", pose.pose().x(), pose.pose().y(), pose.pose().yaw());
  if (pose.covariance_size() != 9) return words;
  return words + fmt::format("  (sigma {:.3f} m, {:.3f} m, {:.4f} rad)", std::sqrt(pose.covariance(0)),
                             std::sqrt(pose.covariance(4)), std::sqrt(pose.covariance(8)));
}

nlohmann::json ToJson(const v1::GlobalPose& pose) {
  nlohmann::json json{{"robot", pose.robot()},
                      {"map", pose.map_pose().map()},
                      {"graph_version", pose.graph_version()},
                      {"search_radius_m", pose.search_radius_m()},
                      {"prior_maps", std::vector<std::string>(pose.prior_maps().begin(), pose.prior_maps().end())},
                      {"prior_hops", nlohmann::json::array()},
                      {"hops", nlohmann::json::array()}};
  if (pose.has_pose_world_robot()) json["pose_world_robot"] = PoseToJson(pose.pose_world_robot());
  for (const v1::PriorHop& hop : pose.prior_hops()) {
    nlohmann::json& out = json["prior_hops"].emplace_back(nlohmann::json{
        {"prior_map", hop.prior_map()}, {"share", std::vector<double>(hop.share().begin(), hop.share().end())}});
    if (hop.has_wall()) out["wall"] = hop.wall();
    if (!hop.shaft().empty()) out["shaft"] = hop.shaft();
  }
  for (const v1::PoseHop& hop : pose.hops()) {
    json["hops"].push_back({{"link_point", hop.link_point()},
                            {"from_map", hop.from_map()},
                            {"to_map", hop.to_map()},
                            {"pose_from_to", PoseToJson(hop.pose_from_to())},
                            {"share", std::vector<double>(hop.share().begin(), hop.share().end())}});
  }
  return json;
}

double PositionVariance(const v1::PoseWithCovariance& pose) {
  const double variance = pose.covariance_size() == 9 ? pose.covariance(0) + pose.covariance(4) : 0.0;
  return variance > 0.0 ? variance : 1.0;
}

// `one_line`: as one item of a stream.
void PrintPose(const Globals& globals, const v1::GlobalPose& pose, bool one_line) {
  if (globals.json) {
    if (one_line) {
      std::cout << ToJson(pose).dump() << std::endl;
    } else {
      PrintJson(std::cout, ToJson(pose));
    }
    return;
  }
  if (!pose.robot().empty()) std::cout << IdOf(pose.robot()) << " in " << IdOf(pose.map_pose().map()) << ": ";
  if (!pose.has_pose_world_robot()) {
    std::cout << "neither link points nor a plan join its map to the root" << std::endl;
    return;
  }
  std::cout << FormatPose(pose.pose_world_robot()) << std::endl;
  for (const v1::PoseHop& hop : pose.hops()) {
    std::cout << fmt::format("  {} -> {} through {}\n", IdOf(hop.from_map()), IdOf(hop.to_map()),
                             IdOf(hop.link_point()));
  }
  for (const std::string& plan : pose.prior_maps()) std::cout << fmt::format("  by plan {}\n", IdOf(plan));
  for (const v1::PriorHop& hop : pose.prior_hops()) {
    const double variance = hop.share_size() == 9 ? hop.share(0) + hop.share(4) : 0.0;
    const std::string what = hop.has_wall()         ? fmt::format("wall {}", hop.wall())
                             : !hop.shaft().empty() ? fmt::format("shaft {}", hop.shaft())
                                                    : "all else";
    std::cout << fmt::format("    {} of {}: {:.1f} % of the position's variance\n", what, IdOf(hop.prior_map()),
                             100.0 * variance / PositionVariance(pose.pose_world_robot()));
  }
  if (!one_line) {
    std::cout << fmt::format("  search radius {:.2f} m, graph version {}\n", pose.search_radius_m(),
                             pose.graph_version());
  }
}

absl::Status PrintGlobalPose(const Globals& globals, const PoseCommandOptions& options) {
  const client::Connection connection = ConnectionOf(globals);
  v1::GetGlobalPoseRequest request;
  if (!options.robot.empty()) {
    request.set_robot(ResourceNameOf(globals, "robots", options.robot));
  } else if (!options.at.empty()) {
    ENFILADE_ASSIGN_OR_RETURN(const PoseInMap found, FindPoseInMap(connection, globals, options.at));
    request.mutable_map_pose()->set_map(found.map);
    *request.mutable_map_pose()->mutable_pose_map_robot()->mutable_pose() = convert::ToProto(found.pose);
  } else {
    return InvalidArgument("no pose is given: use --robot or --at MAP,X,Y,YAW");
  }
  request.set_with_prior_hops(options.walls);
  ENFILADE_ASSIGN_OR_RETURN(const auto response, connection.Call(&v1::GraphService::Stub::GetGlobalPose, request));
  PrintPose(globals, response.global_pose(), false);
  return absl::OkStatus();
}

absl::Status WatchPoses(const Globals& globals, const PoseCommandOptions& options) {
  const client::Connection connection = ConnectionOf(globals);
  v1::WatchGlobalPosesRequest request;
  request.set_parent(SiteNameOf(globals));
  request.set_rate_hz(options.rate_hz);
  if (!options.robot.empty()) request.add_robots(ResourceNameOf(globals, "robots", options.robot));
  const auto stub = v1::GraphService::NewStub(connection.channel());
  grpc::ClientContext context;
  connection.SetMinGraphVersions(context);
  const auto reader = stub->WatchGlobalPoses(&context, request);
  v1::WatchGlobalPosesResponse response;
  while (reader->Read(&response)) {
    for (const v1::GlobalPose& pose : response.global_poses()) PrintPose(globals, pose, true);
  }
  return client::FromGrpcStatus(reader->Finish(), connection.address());
}

v1::PathCost PathCostOf(const std::string& cost) {
  if (cost == "hops") return v1::PATH_COST_HOPS;
  return cost == "uncertainty" ? v1::PATH_COST_UNCERTAINTY : v1::PATH_COST_DISTANCE;
}

absl::StatusOr<v1::FindRoutesRequest> RoutesRequestOf(const client::Connection& connection, const Globals& globals,
                                                      const PoseCommandOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(const PoseInMap start, FindPoseInMap(connection, globals, options.from));
  ENFILADE_ASSIGN_OR_RETURN(const PoseInMap goal, FindPoseInMap(connection, globals, options.to));
  v1::FindRoutesRequest request;
  request.set_start_map(start.map);
  *request.mutable_pose_map_start() = convert::ToProto(start.pose);
  request.set_goal_map(goal.map);
  *request.mutable_pose_map_goal() = convert::ToProto(goal.pose);
  request.set_cost(PathCostOf(options.cost));
  request.set_max_routes(options.alternatives);
  request.set_with_geojson(options.geojson);
  return request;
}

absl::Status PrintRoutes(const Globals& globals, const PoseCommandOptions& options) {
  const client::Connection connection = ConnectionOf(globals);
  ENFILADE_ASSIGN_OR_RETURN(const v1::FindRoutesRequest request, RoutesRequestOf(connection, globals, options));
  ENFILADE_ASSIGN_OR_RETURN(const auto response, connection.Call(&v1::GraphService::Stub::FindRoutes, request));
  if (options.geojson) {
    std::cout << response.geojson() << '\n';
    return absl::OkStatus();
  }
  nlohmann::json documents = nlohmann::json::array();
  std::vector<std::vector<std::string>> rows;
  int number = 0;
  for (const v1::Route& route : response.routes()) {
    ++number;
    nlohmann::json legs = nlohmann::json::array();
    for (const v1::RouteLeg& leg : route.legs()) {
      legs.push_back({{"map", leg.map()}, {"level", leg.level()}, {"length_m", leg.length_m()}, {"exit", leg.exit()}});
      rows.push_back({std::to_string(number), IdOf(leg.map()), std::to_string(leg.level()),
                      fmt::format("{:.2f}", leg.length_m()), leg.exit().empty() ? "goal" : IdOf(leg.exit())});
    }
    documents.push_back({{"length_m", route.length_m()}, {"cost", route.cost()}, {"legs", std::move(legs)}});
  }
  if (globals.json) {
    PrintJson(std::cout, {{"graph_version", response.graph_version()}, {"routes", std::move(documents)}});
  } else if (rows.empty()) {
    std::cout << "no route: no open link points join the two maps\n";
  } else {
    PrintTable(std::cout, {"ROUTE", "MAP", "LEVEL", "LENGTH M", "THEN THROUGH"}, rows);
  }
  return absl::OkStatus();
}

}  // namespace

void AddPose(CLI::App& app, const Globals& globals) {
  const auto options = std::make_shared<PoseCommandOptions>();
  CLI::App* pose = app.add_subcommand("pose", "Robots' poses in the world frame");
  pose->require_subcommand(1);
  CLI::App* global =
      AddCommand(*pose, "global", "Show a pose in the world frame, and the link points that it was chained through",
                 [&globals, options] { return PrintGlobalPose(globals, *options); });
  global->add_option("--robot", options->robot, "The last reported pose of this robot, by its id");
  global->add_option("--at", options->at, "A pose in a map: MAP,X,Y,YAW");
  global->add_flag("--walls", options->walls, "Also how much each wall of a plan contributes to the uncertainty");
  global->footer("Examples: enfilade pose global --robot r1\n          enfilade pose global --at Lab,1,2,0.5");
  CLI::App* watch = AddCommand(*pose, "watch", "Print global poses as they change, until interrupted",
                               [&globals, options] { return WatchPoses(globals, *options); });
  watch->add_option("--robot", options->robot, "Only this robot");
  watch->add_option("--rate", options->rate_hz, "How often at most, Hz")->capture_default_str();
  watch->footer("Example: enfilade --json pose watch --rate 5");
  CLI::App* route = AddCommand(app, "route", "Find routes from a pose in one map to a pose in another",
                               [&globals, options] { return PrintRoutes(globals, *options); });
  route->add_option("FROM", options->from, "MAP,X,Y")->required();
  route->add_option("TO", options->to, "MAP,X,Y")->required();
  route->add_option("--cost", options->cost, "What to minimise")
      ->check(CLI::IsMember({"distance", "hops", "uncertainty"}))
      ->capture_default_str();
  route->add_option("--alternatives", options->alternatives, "How many routes at most")->capture_default_str();
  route->add_flag("--geojson", options->geojson, "Print them as GeoJSON");
  route->footer("Example: enfilade route Hall,1,2 Lab,3,4 --alternatives 3");
}

}  // namespace enfilade::cli
