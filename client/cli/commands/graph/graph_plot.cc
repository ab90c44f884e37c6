// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/cli/commands/commands.h"
#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "client/sdk/api/graph.h"
#include "client/sdk/api/map_export.h"
#include "client/sdk/api/paging.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/graph/search_radius.h"
#include "core/grid/files/map_files.h"
#include "core/plot/scene.h"
#include "enfilade/v1/graph_service.grpc.pb.h"
#include "enfilade/v1/link_point_service.grpc.pb.h"
#include "enfilade/v1/map_service.grpc.pb.h"
#include "io/file.h"
#include "proto/convert/record.h"

namespace enfilade::cli {
namespace {

constexpr std::array<grid::Rgb, 8> kPalette{{{31, 119, 180},
                                             {214, 39, 40},
                                             {44, 160, 44},
                                             {148, 103, 189},
                                             {255, 127, 14},
                                             {23, 140, 160},
                                             {140, 86, 75},
                                             {200, 80, 160}}};
constexpr grid::Rgb kBlack{20, 20, 20};
constexpr grid::Rgb kOrange{230, 120, 0};
constexpr grid::Rgb kGrey{120, 120, 120};

struct GraphPlotCommandOptions {
  std::string output = "graph.png";
  std::string map;
  std::string near;
  std::optional<int> level;
  int size_px = 1600;
};

struct PlottedMap {
  std::string name;
  std::string display_name;
  Pose2 T_scene_map;
  grid::Rgb color{};
};

PoseWithCovariance ToPose(const v1::PoseWithCovariance& pose) {
  PoseWithCovariance result{.pose = convert::FromProto(pose.pose())};
  if (pose.covariance_size() == 9) {
    result.covariance = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(pose.covariance().data());
  }
  return result;
}

// The newest revision of the map; empty if it has none.
absl::StatusOr<std::optional<grid::OccupancyGrid>> FetchGrid(const client::Connection& connection,
                                                             const std::string& map) {
  v1::ExportMapRequest request;
  request.set_name(map);
  request.set_format(v1::MAP_FORMAT_PNG);
  absl::StatusOr<client::DownloadedMap> downloaded = client::DownloadMap(connection, request);
  if (absl::IsNotFound(downloaded.status()) || absl::IsFailedPrecondition(downloaded.status())) return std::nullopt;
  ENFILADE_RETURN_IF_ERROR(downloaded.status());
  std::vector<grid::MapFile> files;
  for (client::NamedFile& file : downloaded->files) files.push_back({std::move(file.name), std::move(file.bytes)});
  ENFILADE_ASSIGN_OR_RETURN(const grid::ImportedMap imported, grid::ImportFiles(files, grid::MapDialect::kNav2));
  return grid::ToOccupancyGrid(imported.raster);
}

void AddAxes(const Pose2& T_scene_map, plot::Scene& scene) {
  const Eigen::Vector2d origin = T_scene_map.translation();
  scene.lines.push_back({{origin, T_scene_map * Eigen::Vector2d(1.0, 0.0)}, grid::kRed, 2});
  scene.lines.push_back({{origin, T_scene_map * Eigen::Vector2d(0.0, 1.0)}, grid::kGreen, 2});
}

// The outline that people have drawn around the map.
absl::Status AddOutline(const client::Connection& connection, const PlottedMap& map, plot::Scene& scene) {
  v1::GetMapRequest request;
  request.set_name(map.name);
  ENFILADE_ASSIGN_OR_RETURN(const auto response, connection.Call(&v1::MapService::Stub::GetMap, request));
  std::vector<Eigen::Vector2d> corners;
  for (const v1::Point& corner : response.map().outline().corners()) {
    corners.push_back(map.T_scene_map * Eigen::Vector2d(corner.x(), corner.y()));
  }
  if (corners.empty()) return absl::OkStatus();
  corners.push_back(corners.front());
  scene.lines.push_back({std::move(corners), map.color, 1});
  return absl::OkStatus();
}

absl::Status AddMap(const client::Connection& connection, const PlottedMap& map, plot::Scene& scene) {
  ENFILADE_RETURN_IF_ERROR(AddOutline(connection, map, scene));
  ENFILADE_ASSIGN_OR_RETURN(auto grid, FetchGrid(connection, map.name));
  if (grid) scene.rasters.push_back({*std::move(grid), map.T_scene_map, map.color});
  AddAxes(map.T_scene_map, scene);
  scene.labels.push_back({map.T_scene_map.translation(), map.display_name, map.color});
  return absl::OkStatus();
}

void AddEllipse(const PoseWithCovariance& pose, grid::Rgb color, plot::Scene& scene) {
  const graph::ErrorEllipse ellipse = graph::ErrorEllipse95(pose.covariance);
  if (!(ellipse.semi_major_m > 0.0)) return;
  scene.ellipses.push_back({pose.pose.translation(), ellipse.semi_major_m, ellipse.semi_minor_m, ellipse.angle, color});
}

void AddPlace(const PoseWithCovariance& place, const std::string& id, int maps, bool joins, plot::Scene& scene) {
  using Shape = plot::SceneMarker::Shape;
  const grid::Rgb color = joins ? kBlack : (maps < 2 ? kOrange : kGrey);
  AddEllipse(place, color, scene);
  scene.markers.push_back(
      {place.pose.translation(), joins ? Shape::kDot : (maps < 2 ? Shape::kCross : Shape::kRing), color});
  scene.labels.push_back({place.pose.translation(), id, color});
}

// The whole site in the world frame.
absl::StatusOr<std::vector<PlottedMap>> AddGraph(const client::Connection& connection, const Globals& globals,
                                                 const GraphPlotCommandOptions& options, plot::Scene& scene) {
  ENFILADE_ASSIGN_OR_RETURN(const v1::Graph graph,
                            client::ReadGraph(connection, SiteNameOf(globals), {.with_edges = true}));
  std::map<std::string, grid::Rgb> colors;  // of the maps drawn
  std::vector<PlottedMap> maps;
  for (int i = 0; i < graph.maps_size(); ++i) {
    const v1::GraphMap& map = graph.maps(i);
    if (!map.has_pose_world_map() || (options.level && map.level() != *options.level)) continue;
    const PoseWithCovariance pose = ToPose(map.pose_world_map());
    maps.push_back({map.map(), map.display_name(), pose.pose, kPalette[static_cast<std::size_t>(i) % kPalette.size()]});
    colors[map.map()] = maps.back().color;
    ENFILADE_RETURN_IF_ERROR(AddMap(connection, maps.back(), scene));
    AddEllipse(pose, maps.back().color, scene);
  }
  std::map<std::string, Eigen::Vector2d> places;
  for (const v1::GraphLinkPoint& point : graph.link_points()) {
    bool drawn = false;
    for (const std::string& map : point.maps()) drawn = drawn || colors.count(map) > 0;
    if (!drawn || !point.has_pose_world_place()) continue;
    const PoseWithCovariance place = ToPose(point.pose_world_place());
    places[point.link_point()] = place.pose.translation();
    AddPlace(place, IdOf(point.link_point()), point.maps_size(), point.joins(), scene);
  }
  for (const v1::GraphEdge& edge : graph.edges()) {
    const auto a = places.find(edge.link_point_a());
    const auto b = places.find(edge.link_point_b());
    const auto color = colors.find(edge.map());
    if (a == places.end() || b == places.end() || color == colors.end()) continue;
    scene.lines.push_back({{a->second, b->second}, color->second, 2});
  }
  return maps;
}

// One map in its own frame, with its link points at their anchors.
absl::StatusOr<std::vector<PlottedMap>> AddOneMap(const client::Connection& connection, const Globals& globals,
                                                  const GraphPlotCommandOptions& options, plot::Scene& scene) {
  ENFILADE_ASSIGN_OR_RETURN(const v1::Map map, FindMap(connection, globals, options.map));
  const PlottedMap plotted{map.name(), map.display_name(), {}, kPalette[0]};
  ENFILADE_RETURN_IF_ERROR(AddMap(connection, plotted, scene));
  v1::ListLinkPointsRequest request;
  request.set_parent(SiteNameOf(globals));
  request.set_map(map.name());
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<v1::LinkPoint> link_points,
                            client::ListAll(connection, &v1::LinkPointService::Stub::ListLinkPoints, request,
                                            &v1::ListLinkPointsResponse::link_points));
  std::vector<Eigen::Vector2d> joining;
  for (const v1::LinkPoint& point : link_points) {
    for (const v1::Anchor& anchor : point.anchors()) {
      if (anchor.map() != map.name()) continue;
      const PoseWithCovariance place = ToPose(anchor.pose_map_place());
      const bool joins = point.anchors_size() > 1 && point.use() == v1::LinkPoint::USE_USED;
      AddPlace(place, IdOf(point.name()), point.anchors_size(), joins, scene);
      if (joins) joining.push_back(place.pose.translation());
    }
  }
  for (std::size_t i = 0; i < joining.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) scene.lines.push_back({{joining[j], joining[i]}, plotted.color, 2});
  }
  return std::vector<PlottedMap>{plotted};
}

// The pose of --near, and the radius within which the server looks for link points around it.
absl::Status AddNear(const client::Connection& connection, const Globals& globals,
                     const GraphPlotCommandOptions& options, const std::vector<PlottedMap>& maps, plot::Scene& scene) {
  ENFILADE_ASSIGN_OR_RETURN(const PoseInMap found, FindPoseInMap(connection, globals, options.near));
  v1::GetGlobalPoseRequest request;
  request.mutable_map_pose()->set_map(found.map);
  *request.mutable_map_pose()->mutable_pose_map_robot()->mutable_pose() = convert::ToProto(found.pose);
  ENFILADE_ASSIGN_OR_RETURN(const auto response, connection.Call(&v1::GraphService::Stub::GetGlobalPose, request));
  PoseWithCovariance robot{.pose = found.pose};
  if (options.map.empty()) {
    if (!response.global_pose().has_pose_world_robot()) {
      return FailedPrecondition("--near {}: no link points join this map to the root: draw it with --map",
                                options.near);
    }
    robot = ToPose(response.global_pose().pose_world_robot());
  } else if (found.map != maps.front().name) {
    return InvalidArgument("--near {}: expected a pose in the map of --map, {}", options.near, options.map);
  }
  const double radius = response.global_pose().has_pose_world_robot() ? response.global_pose().search_radius_m()
                                                                      : graph::SearchRadius(robot.covariance);
  const Eigen::Vector2d at = robot.pose.translation();
  scene.ellipses.push_back({at, radius, radius, 0.0, grid::kRed});
  AddEllipse(robot, grid::kRed, scene);
  scene.lines.push_back({{at, robot.pose * Eigen::Vector2d(1.5, 0.0)}, grid::kRed, 3});
  scene.markers.push_back({at, plot::SceneMarker::Shape::kDot, grid::kRed});
  return absl::OkStatus();
}

absl::Status PlotGraph(const Globals& globals, const GraphPlotCommandOptions& options) {
  const bool svg = options.output.ends_with(".svg");
  if (!svg && !options.output.ends_with(".png")) {
    return InvalidArgument("{}: expected a file that ends in .png or .svg", options.output);
  }
  const client::Connection connection = ConnectionOf(globals);
  plot::Scene scene;
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<PlottedMap> maps, options.map.empty()
                                                                    ? AddGraph(connection, globals, options, scene)
                                                                    : AddOneMap(connection, globals, options, scene));
  if (!options.near.empty()) ENFILADE_RETURN_IF_ERROR(AddNear(connection, globals, options, maps, scene));
  ENFILADE_ASSIGN_OR_RETURN(const plot::SceneView view, plot::ViewOf(scene, options.size_px));
  ENFILADE_ASSIGN_OR_RETURN(const std::string bytes,
                            svg ? plot::WriteSvg(scene, view) : grid::EncodePng(plot::DrawScene(scene, view)));
  ENFILADE_RETURN_IF_ERROR(io::WriteFile(options.output, bytes));
  if (globals.json) {
    PrintJson(std::cout, {{"file", options.output},
                          {"maps", maps.size()},
                          {"grids", scene.rasters.size()},
                          {"link_points", scene.markers.size() - (options.near.empty() ? 0U : 1U)},
                          {"width", view.width},
                          {"height", view.height},
                          {"px_per_m", view.px_per_m}});
    return absl::OkStatus();
  }
  std::cout << fmt::format("{}: {} x {} pixels, {:.1f} per metre\n", options.output, view.width, view.height,
                           view.px_per_m);
  for (const PlottedMap& map : maps) {
    std::cout << fmt::format("#{:02x}{:02x}{:02x}  {}\n", map.color[0], map.color[1], map.color[2], map.display_name);
  }
  return absl::OkStatus();
}

}  // namespace

void AddGraphPlot(CLI::App& graph, const Globals& globals) {
  const auto options = std::make_shared<GraphPlotCommandOptions>();
  CLI::App* plot = AddCommand(graph, "plot", "Draw the maps in the world frame, with link points, candidates and edges",
                              [&globals, options] { return PlotGraph(globals, *options); });
  plot->add_option("-o,--output", options->output, "The file: .png, or .svg (which has names)")->capture_default_str();
  plot->add_option("--map", options->map, "Only this map, in its own frame");
  plot->add_option("--near", options->near, "Also this pose and the search radius around it: MAP,X,Y[,YAW]");
  plot->add_option("--level", options->level, "Only maps on this floor");
  plot->add_option("--size", options->size_px, "The longer side in pixels")->capture_default_str();
  plot->footer("Example: enfilade --site campus graph plot -o campus.svg --near \"Main hall,2,3,1.57\"");
}

}  // namespace enfilade::cli
