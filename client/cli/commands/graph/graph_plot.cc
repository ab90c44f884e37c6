// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "client/cli/commands/commands.h"
#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "client/sdk/api/graph.h"
#include "client/sdk/api/map_export.h"
#include "client/sdk/api/paging.h"
#include "client/sdk/api/world_trajectory.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/graph/search_radius.h"
#include "core/grid/files/map_files.h"
#include "core/plot/scene.h"
#include "core/plot/territories.h"
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
  std::vector<Eigen::Vector2d> drives = {};  // where robots drove in it, m, the scene's frame
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

// Where the map's name stands, and its link points' lines begin: on its drives, near their middle.
Eigen::Vector2d CentreOf(const PlottedMap& map) {
  if (map.drives.empty()) return map.T_scene_map.translation();
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& p : map.drives) mean += p / static_cast<double>(map.drives.size());
  return *std::min_element(
      map.drives.begin(), map.drives.end(),
      [&](const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return (a - mean).norm() < (b - mean).norm(); });
}

absl::Status AddMap(const client::Connection& connection, const PlottedMap& map, int level,
                    std::vector<plot::DrivenRaster>& rasters, plot::Scene& scene) {
  ENFILADE_RETURN_IF_ERROR(AddOutline(connection, map, scene));
  ENFILADE_ASSIGN_OR_RETURN(auto grid, FetchGrid(connection, map.name));
  if (grid) rasters.push_back({{*std::move(grid), map.T_scene_map, map.color}, map.drives, level});
  AddAxes(map.T_scene_map, scene);
  scene.labels.push_back({CentreOf(map), map.display_name, map.color});
  return absl::OkStatus();
}

// Lines from the map's middle to where it is joined to others.
void AddJoins(const PlottedMap& map, const std::vector<Eigen::Vector2d>& places, plot::Scene& scene) {
  const Eigen::Vector2d centre = CentreOf(map);
  for (const Eigen::Vector2d& place : places) scene.lines.push_back({{centre, place}, map.color, 2});
  if (!places.empty()) scene.markers.push_back({centre, plot::SceneMarker::Shape::kSquare, map.color});
}

// By map, in its frame.
absl::StatusOr<std::map<std::string, std::vector<Eigen::Vector2d>>> ReadDrives(const client::Connection& connection,
                                                                               const std::string& site) {
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<client::MappedStretch> stretches,
                            client::ReadPresentStretches(connection, site));
  std::map<std::string, std::vector<Eigen::Vector2d>> drives;
  for (const client::MappedStretch& stretch : stretches) {
    for (const client::MappedPose& pose : stretch.poses) {
      drives[stretch.map].push_back(pose.T_map_robot.translation());
    }
  }
  return drives;
}

// A colour for each map, other ones for maps that are joined, if there are enough.
std::map<std::string, grid::Rgb> ColorsOf(const v1::Graph& graph) {
  std::map<std::string, std::set<std::string>> neighbours;
  for (const v1::GraphLinkPoint& point : graph.link_points()) {
    for (const std::string& a : point.maps()) neighbours[a].insert(point.maps().begin(), point.maps().end());
  }
  std::map<std::string, std::size_t> chosen;
  for (std::size_t i = 0; const v1::GraphMap& map : graph.maps()) {
    std::set<std::size_t> taken;
    for (const std::string& other : neighbours[map.map()]) {
      if (const auto color = chosen.find(other); color != chosen.end()) taken.insert(color->second);
    }
    std::size_t color = i++ % kPalette.size();
    for (std::size_t k = 0; k < kPalette.size() && taken.contains(color); ++k) color = (color + 1) % kPalette.size();
    chosen[map.map()] = color;
  }
  std::map<std::string, grid::Rgb> colors;
  for (const auto& [map, color] : chosen) colors[map] = kPalette[color];
  return colors;
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
  ENFILADE_ASSIGN_OR_RETURN(const v1::Graph graph, client::ReadGraph(connection, SiteNameOf(globals)));
  ENFILADE_ASSIGN_OR_RETURN(auto drives, ReadDrives(connection, SiteNameOf(globals)));
  const std::map<std::string, grid::Rgb> colors = ColorsOf(graph);
  std::vector<PlottedMap> maps;
  std::vector<plot::DrivenRaster> rasters;
  for (const v1::GraphMap& map : graph.maps()) {
    if (!map.has_pose_world_map() || (options.level && map.level() != *options.level)) continue;
    const PoseWithCovariance pose = ToPose(map.pose_world_map());
    maps.push_back({map.map(), map.display_name(), pose.pose, colors.at(map.map()), std::move(drives[map.map()])});
    for (Eigen::Vector2d& p : maps.back().drives) p = pose.pose * p;
    ENFILADE_RETURN_IF_ERROR(AddMap(connection, maps.back(), map.level(), rasters, scene));
    AddEllipse(pose, maps.back().color, scene);
  }
  std::map<std::string, std::vector<Eigen::Vector2d>> joins;  // by map
  std::vector<Eigen::Vector2d> doors;
  for (const v1::GraphLinkPoint& point : graph.link_points()) {
    const bool drawn = std::any_of(maps.begin(), maps.end(), [&](const PlottedMap& map) {
      return std::find(point.maps().begin(), point.maps().end(), map.name) != point.maps().end();
    });
    if (!drawn || !point.has_pose_world_place()) continue;
    const PoseWithCovariance place = ToPose(point.pose_world_place());
    AddPlace(place, IdOf(point.link_point()), point.maps_size(), point.joins(), scene);
    if (!point.joins()) continue;
    doors.push_back(place.pose.translation());
    for (const std::string& map : point.maps()) joins[map].push_back(place.pose.translation());
  }
  scene.rasters = plot::CutToTerritories(std::move(rasters), doors);
  for (const PlottedMap& map : maps) AddJoins(map, joins[map.name], scene);
  return maps;
}

// One map in its own frame, with its link points at their anchors.
absl::StatusOr<std::vector<PlottedMap>> AddOneMap(const client::Connection& connection, const Globals& globals,
                                                  const GraphPlotCommandOptions& options, plot::Scene& scene) {
  ENFILADE_ASSIGN_OR_RETURN(const v1::Map map, FindMap(connection, globals, options.map));
  ENFILADE_ASSIGN_OR_RETURN(auto drives, ReadDrives(connection, SiteNameOf(globals)));
  const PlottedMap plotted{map.name(), map.display_name(), {}, kPalette[0], std::move(drives[map.name()])};
  std::vector<plot::DrivenRaster> rasters;
  ENFILADE_RETURN_IF_ERROR(AddMap(connection, plotted, map.level(), rasters, scene));
  for (plot::DrivenRaster& driven : rasters) scene.rasters.push_back(std::move(driven.raster));
  v1::ListLinkPointsRequest request;
  request.set_parent(SiteNameOf(globals));
  request.set_map(map.name());
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<v1::LinkPoint> link_points,
                            client::ListAll(connection, &v1::LinkPointService::Stub::ListLinkPoints, request,
                                            &v1::ListLinkPointsResponse::link_points));
  std::vector<Eigen::Vector2d> joins;
  for (const v1::LinkPoint& point : link_points) {
    for (const v1::Anchor& anchor : point.anchors()) {
      if (anchor.map() != map.name()) continue;
      const PoseWithCovariance place = ToPose(anchor.pose_map_place());
      const bool is_join = point.anchors_size() > 1 && point.use() == v1::LinkPoint::USE_USED;
      AddPlace(place, IdOf(point.name()), point.anchors_size(), is_join, scene);
      if (is_join) joins.push_back(place.pose.translation());
    }
  }
  AddJoins(plotted, joins, scene);
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
    const auto link_points = std::count_if(scene.markers.begin(), scene.markers.end(), [](const auto& marker) {
      return marker.shape != plot::SceneMarker::Shape::kSquare;
    });
    PrintJson(std::cout, {{"file", options.output},
                          {"maps", maps.size()},
                          {"grids", scene.rasters.size()},
                          {"link_points", link_points - (options.near.empty() ? 0 : 1)},
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
  CLI::App* plot = AddCommand(graph, "plot", "Draw the maps in the world frame, with link points and candidates",
                              [&globals, options] { return PlotGraph(globals, *options); });
  plot->add_option("-o,--output", options->output, "The file: .png, or .svg (which has names)")->capture_default_str();
  plot->add_option("--map", options->map, "Only this map, in its own frame");
  plot->add_option("--near", options->near, "Also this pose and the search radius around it: MAP,X,Y[,YAW]");
  plot->add_option("--level", options->level, "Only maps on this floor");
  plot->add_option("--size", options->size_px, "The longer side in pixels")->capture_default_str();
  plot->footer("Example: enfilade --site campus graph plot -o campus.svg --near \"Main hall,2,3,1.57\"");
}

}  // namespace enfilade::cli
