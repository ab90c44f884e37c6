// SPDX-License-Identifier: Apache-2.0
// `enfilade graph diff`.
#include <algorithm>
#include <cmath>
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/cli/commands/commands.h"
#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "client/sdk/api/paging.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/geometry/pose2.h"
#include "core/plot/scene.h"
#include "enfilade/v1/graph_service.grpc.pb.h"
#include "enfilade/v1/map_service.grpc.pb.h"
#include "io/file.h"
#include "proto/convert/record.h"

namespace enfilade::cli {
namespace {

constexpr double kMoved_m = 1e-3;
constexpr double kMoved_rad = 1e-4;
constexpr grid::Rgb kBefore{150, 150, 150};
constexpr grid::Rgb kAfter{31, 119, 180};

struct GraphDiffCommandOptions {
  std::int64_t before = 0;
  std::int64_t after = 0;
  std::string output;
  int size_px = 1600;
};

// A map that one of two optimisations placed.
struct PlacedTwice {
  std::string map;
  std::string display_name;
  std::optional<Pose2> before;
  std::optional<Pose2> after;

  bool was_there_twice() const { return before && after; }
  double distance_m() const { return (after->translation() - before->translation()).norm(); }
  double turn_rad() const { return std::remainder(after->yaw - before->yaw, 2 * M_PI); }
  bool has_moved() const { return was_there_twice() && (distance_m() > kMoved_m || std::abs(turn_rad()) > kMoved_rad); }
};

absl::StatusOr<std::map<std::string, Pose2>> ReadPlaces(const client::Connection& connection, const Globals& globals,
                                                        std::int64_t version) {
  v1::ListPlacedMapsRequest request;
  request.set_parent(SiteNameOf(globals));
  request.set_graph_version(version);
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<v1::PlacedMap> placed,
                            client::ListAll(connection, &v1::GraphService::Stub::ListPlacedMaps, request,
                                            &v1::ListPlacedMapsResponse::placed_maps));
  std::map<std::string, Pose2> places;
  for (const v1::PlacedMap& map : placed) places[map.map()] = convert::FromProto(map.pose_world_map().pose());
  return places;
}

// Those that moved, the farthest first, then those that only one of the two placed.
absl::StatusOr<std::vector<PlacedTwice>> ReadMoves(const Globals& globals, const GraphDiffCommandOptions& options) {
  const client::Connection connection = ConnectionOf(globals);
  ENFILADE_ASSIGN_OR_RETURN(const auto before, ReadPlaces(connection, globals, options.before));
  ENFILADE_ASSIGN_OR_RETURN(const auto after, ReadPlaces(connection, globals, options.after));
  v1::ListMapsRequest request;
  request.set_parent(SiteNameOf(globals));
  ENFILADE_ASSIGN_OR_RETURN(
      const std::vector<v1::Map> maps,
      client::ListAll(connection, &v1::MapService::Stub::ListMaps, request, &v1::ListMapsResponse::maps));
  std::map<std::string, PlacedTwice> placed;
  for (const auto& [map, pose] : before) placed[map].before = pose;
  for (const auto& [map, pose] : after) placed[map].after = pose;
  for (const v1::Map& map : maps) {
    const auto found = placed.find(map.name());
    if (found != placed.end()) found->second.display_name = map.display_name();
  }
  std::vector<PlacedTwice> moves;
  for (auto& [map, twice] : placed) {
    twice.map = map;
    moves.push_back(std::move(twice));
  }
  std::stable_sort(moves.begin(), moves.end(), [](const PlacedTwice& a, const PlacedTwice& b) {
    if (a.was_there_twice() != b.was_there_twice()) return a.was_there_twice();
    return a.was_there_twice() && a.distance_m() > b.distance_m();
  });
  return moves;
}

// An arrow of metres, with a head of a fifth of its length.
void AddArrow(const Eigen::Vector2d& from, const Eigen::Vector2d& to, plot::Scene& scene) {
  const Eigen::Vector2d back = 0.2 * (from - to);
  const Eigen::Vector2d aside = 0.4 * Eigen::Vector2d(-back.y(), back.x());
  scene.lines.push_back({{from, to}, kAfter, 2});
  scene.lines.push_back({{to + back + aside, to, to + back - aside}, kAfter, 2});
}

plot::Scene SceneOf(const std::vector<PlacedTwice>& maps) {
  using Shape = plot::SceneMarker::Shape;
  plot::Scene scene;
  for (const PlacedTwice& map : maps) {
    if (map.before) scene.markers.push_back({map.before->translation(), Shape::kRing, kBefore});
    if (map.after) scene.markers.push_back({map.after->translation(), Shape::kDot, kAfter});
    const Eigen::Vector2d at = (map.after ? map.after : map.before)->translation();
    std::string label = map.display_name.empty() ? IdOf(map.map) : map.display_name;
    if (map.has_moved()) {
      AddArrow(map.before->translation(), map.after->translation(), scene);
      label += fmt::format(" {:.2f} m", map.distance_m());
    }
    scene.labels.push_back({at, label, map.after ? kAfter : kBefore});
  }
  return scene;
}

absl::Status PlotMoves(const std::vector<PlacedTwice>& maps, const GraphDiffCommandOptions& options) {
  const plot::Scene scene = SceneOf(maps);
  ENFILADE_ASSIGN_OR_RETURN(const plot::SceneView view, plot::ViewOf(scene, options.size_px));
  ENFILADE_ASSIGN_OR_RETURN(const std::string bytes, options.output.ends_with(".svg")
                                                         ? plot::WriteSvg(scene, view)
                                                         : grid::EncodePng(plot::DrawScene(scene, view)));
  return io::WriteFile(options.output, bytes);
}

nlohmann::json MoveToJson(const PlacedTwice& map) {
  nlohmann::json json{{"map", map.map}, {"display_name", map.display_name}};
  if (map.before) json["before"] = {map.before->x, map.before->y, map.before->yaw};
  if (map.after) json["after"] = {map.after->x, map.after->y, map.after->yaw};
  if (map.was_there_twice()) {
    json["distance_m"] = map.distance_m();
    json["turn_rad"] = map.turn_rad();
  }
  return json;
}

std::vector<std::string> MoveToRow(const PlacedTwice& map) {
  std::vector<std::string> row{IdOf(map.map), map.display_name};
  if (!map.was_there_twice()) {
    row.emplace_back(map.after ? "placed" : "no longer placed");
    row.emplace_back();
    return row;
  }
  row.push_back(fmt::format("{:.3f} m", map.distance_m()));
  row.push_back(fmt::format("{:.2f} deg", map.turn_rad() * 180.0 / M_PI));
  return row;
}

absl::Status DiffGraph(const Globals& globals, const GraphDiffCommandOptions& options) {
  if (!options.output.empty() && !options.output.ends_with(".png") && !options.output.ends_with(".svg")) {
    return InvalidArgument("--plot {}: expected a file that ends in .png or .svg", options.output);
  }
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<PlacedTwice> maps, ReadMoves(globals, options));
  if (!options.output.empty()) ENFILADE_RETURN_IF_ERROR(PlotMoves(maps, options));
  std::vector<PlacedTwice> changed;
  std::copy_if(maps.begin(), maps.end(), std::back_inserter(changed),
               [](const PlacedTwice& map) { return map.has_moved() || !map.was_there_twice(); });
  if (globals.json) {
    nlohmann::json moves = nlohmann::json::array();
    for (const PlacedTwice& map : changed) moves.push_back(MoveToJson(map));
    nlohmann::json document{{"before", options.before}, {"after", options.after}, {"maps", std::move(moves)}};
    if (!options.output.empty()) document["file"] = options.output;
    PrintJson(std::cout, document);
    return absl::OkStatus();
  }
  std::cout << fmt::format("graph version {} -> {}: {} of {} maps have another place\n", options.before, options.after,
                           changed.size(), maps.size());
  std::vector<std::vector<std::string>> rows;
  for (const PlacedTwice& map : changed) rows.push_back(MoveToRow(map));
  if (!rows.empty()) PrintTable(std::cout, {"MAP", "NAME", "MOVED", "TURNED"}, rows);
  if (!options.output.empty()) std::cout << options.output << '\n';
  return absl::OkStatus();
}

}  // namespace

void AddGraphDiff(CLI::App& graph, const Globals& globals) {
  const auto options = std::make_shared<GraphDiffCommandOptions>();
  CLI::App* command = AddCommand(graph, "diff", "Show which maps have moved between two optimisations, and how far",
                                 [&globals, options] { return DiffGraph(globals, *options); });
  command->add_option("V1", options->before, "A version that an optimisation made (see graph versions)")
      ->required()
      ->check(CLI::PositiveNumber);
  command->add_option("V2", options->after, "Another one")->required()->check(CLI::PositiveNumber);
  command->add_option("--plot", options->output, "Draw the moves as arrows: .png, or .svg (which has names)");
  command->add_option("--size", options->size_px, "The longer side of the drawing in pixels")->capture_default_str();
  command->footer("Example: enfilade --site campus graph diff 812 840 --plot moves.svg");
}

}  // namespace enfilade::cli
