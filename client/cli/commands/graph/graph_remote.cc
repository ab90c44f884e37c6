// SPDX-License-Identifier: Apache-2.0
#include "client/cli/commands/graph/graph_remote.h"

#include <algorithm>
#include <iostream>
#include <memory>

#include "client/cli/commands/graph/graph_plot.h"
#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "core/base/error.h"
#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "enfilade/v1/graph_service.grpc.pb.h"
#include "io/file.h"

namespace enfilade::cli {
namespace {

using GraphStub = v1::GraphService::Stub;

std::string PoseInWords(const v1::Pose2& pose) {
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

absl::Status ShowGraph(const Globals& globals, std::int64_t version) {
  v1::GetGraphRequest request;
  request.set_site(SiteNameOf(globals));
  request.set_graph_version(version);
  ENFILADE_ASSIGN_OR_RETURN(const auto response, ConnectionOf(globals).Call(&GraphStub::GetGraph, request));
  const v1::Graph& graph = response.graph();
  if (globals.json) {
    PrintJson(std::cout, ToJson(graph));
    return absl::OkStatus();
  }
  std::cout << fmt::format("graph version {}: {} maps, {} link points, {} edges; root {}\n\n", graph.graph_version(),
                           graph.maps_size(), graph.link_points_size(), graph.edges_size(),
                           graph.root_map().empty() ? "-" : IdOf(graph.root_map()));
  std::vector<std::vector<std::string>> rows;
  for (const v1::GraphMap& map : graph.maps()) {
    rows.push_back({IdOf(map.map()), map.display_name(), std::to_string(map.level()),
                    map.has_pose_world_map() ? PoseInWords(map.pose_world_map().pose()) : "not joined",
                    map.optimized() ? "optimised" : "chained"});
  }
  PrintTable(std::cout, {"MAP", "NAME", "LEVEL", "WORLD X Y YAW", "FROM"}, rows);
  rows.clear();
  for (const v1::GraphLinkPoint& point : graph.link_points()) {
    std::string maps;
    for (const std::string& map : point.maps()) maps += (maps.empty() ? "" : " - ") + IdOf(map);
    rows.push_back({IdOf(point.link_point()), maps,
                    point.has_pose_world_place() ? PoseInWords(point.pose_world_place().pose()) : "not joined",
                    point.joins() ? "joins" : (point.maps_size() < 2 ? "candidate" : "not used")});
  }
  std::cout << '\n';
  PrintTable(std::cout, {"LINK POINT", "MAPS", "WORLD X Y YAW", "STATE"}, rows);
  rows.clear();
  for (const v1::GraphEdge& edge : graph.edges()) {
    rows.push_back({IdOf(edge.map()), IdOf(edge.link_point_a()), IdOf(edge.link_point_b()),
                    fmt::format("{:.2f}", edge.length_m())});
  }
  std::cout << '\n';
  PrintTable(std::cout, {"THROUGH MAP", "FROM", "TO", "LENGTH M"}, rows);
  return absl::OkStatus();
}

std::string CauseInWords(v1::GraphVersion::Cause cause) {
  std::string words = v1::GraphVersion::Cause_Name(cause).substr(sizeof("CAUSE_") - 1);
  for (char& c : words) c = c == '_' ? ' ' : static_cast<char>(std::tolower(c));
  return words;
}

absl::Status ListVersions(const Globals& globals, int count) {
  const client::Connection connection = ConnectionOf(globals);
  nlohmann::json documents = nlohmann::json::array();
  std::vector<std::vector<std::string>> rows;
  v1::ListGraphVersionsRequest request;
  request.set_parent(SiteNameOf(globals));
  do {
    request.set_page_size(std::min(count - static_cast<int>(rows.size()), 1000));
    ENFILADE_ASSIGN_OR_RETURN(const auto page, connection.Call(&GraphStub::ListGraphVersions, request));
    for (const v1::GraphVersion& version : page.graph_versions()) {
      documents.push_back(
          {{"graph_version", version.graph_version()},
           {"cause", CauseInWords(version.cause())},
           {"resource", version.resource()},
           {"actor", version.actor()},
           {"create_time", TimeInWords(version.create_time())},
           {"chi2_before", version.chi2_before()},
           {"chi2_after", version.chi2_after()},
           {"switched_off", std::vector<std::string>(version.switched_off().begin(), version.switched_off().end())}});
      const bool optimized = version.cause() == v1::GraphVersion::CAUSE_OPTIMIZED;
      rows.push_back({std::to_string(version.graph_version()), CauseInWords(version.cause()), version.resource(),
                      version.actor().empty() ? "-" : version.actor(), TimeInWords(version.create_time()),
                      optimized ? fmt::format("chi2 {:.3g} -> {:.3g}, {} switched off", version.chi2_before(),
                                              version.chi2_after(), version.switched_off_size())
                                : ""});
    }
    request.set_page_token(page.next_page_token());
  } while (!request.page_token().empty() && static_cast<int>(rows.size()) < count);
  if (globals.json) {
    PrintJson(std::cout, documents);
  } else {
    PrintTable(std::cout, {"VERSION", "CAUSE", "RESOURCE", "WHO", "WHEN (UTC)", "RESULT"}, rows);
  }
  return absl::OkStatus();
}

absl::Status RequestOptimization(const Globals& globals) {
  v1::OptimizeGraphRequest request;
  request.set_site(SiteNameOf(globals));
  ENFILADE_ASSIGN_OR_RETURN(const auto response, ConnectionOf(globals).Call(&GraphStub::OptimizeGraph, request));
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

absl::Status ExportGraph(const Globals& globals, const std::string& path) {
  const client::Connection connection = ConnectionOf(globals);
  const auto stub = v1::GraphService::NewStub(connection.channel());
  grpc::ClientContext context;
  connection.SetDeadline(context);
  v1::ExportGraphRequest request;
  request.set_site(SiteNameOf(globals));
  const auto reader = stub->ExportGraph(&context, request);
  std::string bytes, sha256;
  std::int64_t version = 0;
  v1::ExportGraphResponse response;
  while (reader->Read(&response)) {
    if (response.has_manifest()) {
      version = response.manifest().graph_version();
      if (response.manifest().files_size() > 0) sha256 = response.manifest().files(0).sha256();
    }
    bytes += response.chunk().data();
  }
  ENFILADE_RETURN_IF_ERROR(client::FromGrpcStatus(reader->Finish(), connection.address()));
  if (Sha256(bytes) != sha256) return DataLoss("the graph came with another SHA-256 than was announced: try again");
  ENFILADE_RETURN_IF_ERROR(io::WriteFile(path, bytes));
  if (globals.json) {
    PrintJson(std::cout, {{"file", path}, {"graph_version", version}, {"bytes", bytes.size()}});
  } else {
    std::cout << fmt::format("{}: graph version {}, {}\n", path, version,
                             BytesInWords(static_cast<std::int64_t>(bytes.size())));
  }
  return absl::OkStatus();
}

}  // namespace

void AddGraphRemote(CLI::App& app, const Globals& globals) {
  CLI::App& graph = *app.get_subcommand("graph");
  const auto version = std::make_shared<std::int64_t>(0);
  CLI::App* show = AddCommand(graph, "show", "Show the site's maps, link points and edges",
                              [&globals, version] { return ShowGraph(globals, *version); });
  show->add_option("--version", *version, "An earlier version of the graph that the server still keeps");
  show->footer("Example: enfilade --site campus graph show");
  const auto count = std::make_shared<int>(20);
  CLI::App* versions = AddCommand(graph, "versions", "Show who changed the graph when, and what optimisations found",
                                  [&globals, count] { return ListVersions(globals, *count); });
  versions->add_option("--count", *count, "At most so many")->check(CLI::PositiveNumber)->capture_default_str();
  versions->footer("Example: enfilade graph versions --count 100");
  AddCommand(graph, "optimize", "Solve for all maps' places in the world now", [&globals] {
    return RequestOptimization(globals);
  })->footer("Example: enfilade --site campus graph optimize");
  const auto path = std::make_shared<std::string>("graph.geojson");
  CLI::App* output = AddCommand(graph, "export", "Write the graph as GeoJSON",
                                [&globals, path] { return ExportGraph(globals, *path); });
  output->add_option("-o,--output", *path, "The file")->capture_default_str();
  output->footer("Example: enfilade graph export -o campus.geojson");
  AddGraphPlot(graph, globals);
}

}  // namespace enfilade::cli
