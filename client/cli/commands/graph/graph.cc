// SPDX-License-Identifier: Apache-2.0
#include "client/sdk/api/graph.h"

#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "client/cli/commands/commands.h"
#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "client/sdk/api/graph_export.h"
#include "client/sdk/api/paging.h"
#include "core/base/status_macros.h"
#include "enfilade/v1/graph_service.grpc.pb.h"
#include "io/file.h"

namespace enfilade::cli {
namespace {

std::string FormatPose(const v1::Pose2& pose) {
  return fmt::format("{:.3f} {:.3f} {:.4f}", pose.x(), pose.y(), pose.yaw());
}

nlohmann::json ToJson(const v1::Graph& graph) {
  nlohmann::json json{{"site", graph.site()},
                      {"graph_version", graph.graph_version()},
                      {"root_map", graph.root_map()},
                      {"solution_version", graph.solution_version()},
                      {"maps", nlohmann::json::array()},
                      {"link_points", nlohmann::json::array()},
                      {"edges", nlohmann::json::array()}};
  for (const v1::GraphMap& map : graph.maps()) {
    nlohmann::json item{{"map", map.map()}, {"display_name", map.display_name()}, {"level", map.level()}};
    if (map.has_pose_world_map()) item["pose_world_map"] = PoseToJson(map.pose_world_map());
    json["maps"].push_back(std::move(item));
  }
  for (const v1::GraphLinkPoint& point : graph.link_points()) {
    nlohmann::json item{{"link_point", point.link_point()},
                        {"maps", std::vector<std::string>(point.maps().begin(), point.maps().end())},
                        {"joins", point.joins()}};
    if (point.has_pose_world_place()) item["pose_world_place"] = PoseToJson(point.pose_world_place());
    json["link_points"].push_back(std::move(item));
  }
  for (const v1::GraphEdge& edge : graph.edges()) {
    json["edges"].push_back({{"map", edge.map()},
                             {"link_point_a", edge.link_point_a()},
                             {"link_point_b", edge.link_point_b()},
                             {"length_m", edge.length_m()}});
  }
  return json;
}

void PrintMaps(const v1::Graph& graph) {
  std::vector<std::vector<std::string>> rows;
  for (const v1::GraphMap& map : graph.maps()) {
    rows.push_back({IdOf(map.map()), map.display_name(), std::to_string(map.level()),
                    map.has_pose_world_map() ? FormatPose(map.pose_world_map().pose()) : "not joined",
                    map.optimized() ? "optimised" : "chained"});
  }
  PrintTable(std::cout, {"MAP", "NAME", "LEVEL", "WORLD X Y YAW", "FROM"}, rows);
}

void PrintLinkPoints(const v1::Graph& graph) {
  std::vector<std::vector<std::string>> rows;
  for (const v1::GraphLinkPoint& point : graph.link_points()) {
    std::string maps;
    for (const std::string& map : point.maps()) maps += (maps.empty() ? "" : " - ") + IdOf(map);
    rows.push_back({IdOf(point.link_point()), maps,
                    point.has_pose_world_place() ? FormatPose(point.pose_world_place().pose()) : "not joined",
                    point.joins() ? "joins" : (point.maps_size() < 2 ? "candidate" : "not used")});
  }
  PrintTable(std::cout, {"LINK POINT", "MAPS", "WORLD X Y YAW", "STATE"}, rows);
}

void PrintEdges(const v1::Graph& graph) {
  std::vector<std::vector<std::string>> rows;
  for (const v1::GraphEdge& edge : graph.edges()) {
    rows.push_back({IdOf(edge.map()), IdOf(edge.link_point_a()), IdOf(edge.link_point_b()),
                    fmt::format("{:.2f}", edge.length_m())});
  }
  PrintTable(std::cout, {"THROUGH MAP", "FROM", "TO", "LENGTH M"}, rows);
}

absl::Status ShowGraph(const Globals& globals, const client::GraphRead& read) {
  ENFILADE_ASSIGN_OR_RETURN(const v1::Graph graph, client::ReadGraph(ConnectionOf(globals), SiteNameOf(globals), read));
  if (globals.json) {
    PrintJson(std::cout, ToJson(graph));
    return absl::OkStatus();
  }
  std::cout << fmt::format("graph version {}: {} maps, {} link points{}; root {}\n\n", graph.graph_version(),
                           graph.maps_size(), graph.link_points_size(),
                           read.with_edges ? fmt::format(", {} edges", graph.edges_size()) : "",
                           IdOf(graph.root_map()));
  PrintMaps(graph);
  std::cout << '\n';
  PrintLinkPoints(graph);
  if (read.with_edges) {
    std::cout << '\n';
    PrintEdges(graph);
  }
  return absl::OkStatus();
}

std::string CauseName(v1::GraphVersion::Cause cause) { return EnumText(v1::GraphVersion::Cause_Name(cause), "CAUSE_"); }

nlohmann::json ToJson(const v1::GraphVersion& version) {
  return {{"graph_version", version.graph_version()},
          {"cause", CauseName(version.cause())},
          {"resource", version.resource()},
          {"actor", version.actor()},
          {"create_time", FormatTime(version.create_time())},
          {"chi2_before", version.chi2_before()},
          {"chi2_after", version.chi2_after()},
          {"switched_off", std::vector<std::string>(version.switched_off().begin(), version.switched_off().end())}};
}

std::vector<std::string> ToRow(const v1::GraphVersion& version) {
  const bool optimized = version.cause() == v1::GraphVersion::CAUSE_OPTIMIZED;
  return {std::to_string(version.graph_version()),
          CauseName(version.cause()),
          version.resource(),
          version.actor().empty() ? "-" : version.actor(),
          FormatTime(version.create_time()),
          optimized ? fmt::format("chi2 {:.3g} -> {:.3g}, {} switched off", version.chi2_before(), version.chi2_after(),
                                  version.switched_off_size())
                    : ""};
}

absl::Status ListVersions(const Globals& globals, int count) {
  v1::ListGraphVersionsRequest request;
  request.set_parent(SiteNameOf(globals));
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<v1::GraphVersion> versions,
                            client::ListAll(ConnectionOf(globals), &v1::GraphService::Stub::ListGraphVersions, request,
                                            &v1::ListGraphVersionsResponse::graph_versions, count));
  PrintList<v1::GraphVersion>(globals, versions, {"VERSION", "CAUSE", "RESOURCE", "WHO", "WHEN (UTC)", "RESULT"},
                              ToJson, ToRow);
  return absl::OkStatus();
}

absl::Status RequestOptimization(const Globals& globals) {
  v1::OptimizeGraphRequest request;
  request.set_site(SiteNameOf(globals));
  ENFILADE_ASSIGN_OR_RETURN(const auto response,
                            ConnectionOf(globals).Call(&v1::GraphService::Stub::OptimizeGraph, request));
  if (globals.json) {
    nlohmann::json switched_off = nlohmann::json::array();
    for (const auto& point : response.switched_off()) {
      switched_off.push_back({{"link_point", point.link_point()}, {"chi2", point.chi2()}, {"gate", point.gate()}});
    }
    PrintJson(std::cout, {{"graph_version", response.graph_version()},
                          {"solved_version", response.solved_version()},
                          {"chi2_before", response.chi2_before()},
                          {"chi2_after", response.chi2_after()},
                          {"degrees_of_freedom", response.degrees_of_freedom()},
                          {"iterations", response.iterations()},
                          {"converged", response.converged()},
                          {"maps", response.maps()},
                          {"switched_off", std::move(switched_off)}});
    return absl::OkStatus();
  }
  std::cout << fmt::format(
      "graph version {}: {} maps placed, chi2 {:.4g} -> {:.4g} ({} degrees of freedom), {} iterations{}\n",
      response.graph_version(), response.maps(), response.chi2_before(), response.chi2_after(),
      response.degrees_of_freedom(), response.iterations(), response.converged() ? "" : ", not converged");
  for (const auto& point : response.switched_off()) {
    std::cout << fmt::format("switched off {}: chi2 {:.4g}, allowed {:.4g}\n", IdOf(point.link_point()), point.chi2(),
                             point.gate());
  }
  for (const std::string& map : response.disconnected_maps()) {
    std::cout << "not joined to the root: " << IdOf(map) << '\n';
  }
  return absl::OkStatus();
}

absl::Status ExportGraph(const Globals& globals, const std::string& path, const client::GraphContent& content) {
  ENFILADE_ASSIGN_OR_RETURN(const client::ExportedGraph graph,
                            client::ExportGraph(ConnectionOf(globals), SiteId(globals.site), content));
  ENFILADE_RETURN_IF_ERROR(io::WriteFile(path, graph.geojson));
  if (globals.json) {
    PrintJson(std::cout, {{"file", path}, {"graph_version", graph.version}, {"bytes", graph.geojson.size()}});
  } else {
    std::cout << fmt::format("{}: graph version {}, {}\n", path, graph.version,
                             FormatBytes(static_cast<std::int64_t>(graph.geojson.size())));
  }
  return absl::OkStatus();
}

}  // namespace

void AddGraph(CLI::App& app, const Globals& globals) {
  CLI::App& graph = *app.add_subcommand("graph", "The graph of the site's maps; pose graphs in files");
  graph.require_subcommand(1);
  const auto read = std::make_shared<client::GraphRead>();
  CLI::App* show = AddCommand(graph, "show", "Show the site's maps and link points",
                              [&globals, read] { return ShowGraph(globals, *read); });
  show->add_option("--version", read->version, "An earlier version that the server still has (default: the newest)");
  show->add_flag("--edges", read->with_edges, "Also the edges: one for each two link points of a map");
  show->footer("Example: enfilade --site campus graph show");
  const auto count = std::make_shared<int>(20);
  CLI::App* versions =
      AddCommand(graph, "versions", "Show who changed the graph and what optimisations found, the newest first",
                 [&globals, count] { return ListVersions(globals, *count); });
  versions->add_option("--count", *count, "How many at most")->check(CLI::PositiveNumber)->capture_default_str();
  versions->footer("Example: enfilade graph versions --count 100");
  AddCommand(graph, "optimize", "Optimise the poses of all maps in the world frame now", [&globals] {
    return RequestOptimization(globals);
  })->footer("Example: enfilade --site campus graph optimize");
  const auto path = std::make_shared<std::string>("graph.geojson");
  const auto content = std::make_shared<client::GraphContent>();
  CLI::App* output = AddCommand(graph, "export", "Write the graph as GeoJSON",
                                [&globals, path, content] { return ExportGraph(globals, *path, *content); });
  output->add_option("-o,--output", *path, "The file")->capture_default_str();
  output->add_flag("!--no-edges", content->with_edges,
                   "Only maps and link points: maps with many doors have many edges");
  output->footer("Example: enfilade graph export -o campus.geojson");
  AddGraphDiff(graph, globals);
  AddGraphChange(graph, globals);
  AddGraphPlot(graph, globals);
  AddGraphSolve(graph, globals);
}

}  // namespace enfilade::cli
