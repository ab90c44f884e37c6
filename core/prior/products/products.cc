// SPDX-License-Identifier: Apache-2.0
#include "core/prior/products/products.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/status_macros.h"
#include "core/grid/files/png_codec.h"
#include "core/plot/scene.h"
#include "core/prior/fit/planning_map.h"
#include "core/prior/formats/building_plan.h"
#include "core/prior/formats/svg_plan.h"
#include "core/prior/products/report.h"
#include "nlohmann/json.hpp"

namespace enfilade::prior {
namespace {

constexpr int kPlotSide = 1600;  // px
constexpr grid::Rgb kOrange{255, 127, 14};

grid::Rgb ColorOf(Sight sight) {
  switch (sight) {
    case Sight::kSeen:
      return grid::kGreen;
    case Sight::kUnseen:
      return grid::kBlue;
    case Sight::kContradicted:
      return grid::kRed;
  }
  return grid::kBlue;
}

nlohmann::json Position(const Eigen::Vector2d& point) { return {point.x(), point.y()}; }

// Each wall with `state`, `stretch`, `thickness` (m) and `sigma_m`, then those that only robots have seen, then each
// door with `state` (seen: robots know the ground there) and `sigma_m`.
std::string WriteCorrectedWalls(const PlanGraph& plan, const PlanFit& fit) {
  const CorrectedPlan& corrected = *fit.corrected;
  nlohmann::json features = nlohmann::json::array();
  for (std::size_t i = 0; i < plan.walls.size(); ++i) {
    const CorrectedCorner& from = corrected.corners()[static_cast<std::size_t>(plan.walls[i].from)];
    const CorrectedCorner& to = corrected.corners()[static_cast<std::size_t>(plan.walls[i].to)];
    const CorrectedWall& wall = corrected.walls()[i];
    const double variance = std::max(from.covariance.trace(), to.covariance.trace()) / 2;
    features.push_back(
        {{"type", "Feature"},
         {"geometry", {{"type", "LineString"}, {"coordinates", {Position(from.point), Position(to.point)}}}},
         {"properties",
          {{"kind", "wall"},
           {"state", NameOf(wall.sight)},
           {"seen", wall.seen_share},
           {"contradicted", wall.contradicted_share},
           {"stretch", wall.stretch},
           {"thickness", plan.walls[i].thickness * corrected.scale()},
           {"sigma_m", std::sqrt(std::max(0.0, variance))}}}});
  }
  for (const AddedWall& wall : fit.added) {
    features.push_back(
        {{"type", "Feature"},
         {"geometry", {{"type", "LineString"}, {"coordinates", {Position(wall.from), Position(wall.to)}}}},
         {"properties", {{"kind", "wall"}, {"state", "added"}}}});
  }
  for (const PlanDoor& door : plan.doors) {
    const CorrectedPoint from = corrected.Locate(door.from), to = corrected.Locate(door.to);
    const CorrectedPoint middle = corrected.Locate(0.5 * (door.from + door.to));
    features.push_back(
        {{"type", "Feature"},
         {"geometry", {{"type", "LineString"}, {"coordinates", {Position(from.point), Position(to.point)}}}},
         {"properties",
          {{"kind", "door"}, {"state", NameOf(middle.sight)}, {"sigma_m", std::max(from.sigma, to.sigma)}}}});
  }
  return nlohmann::json{{"type", "FeatureCollection"}, {"frame", "metres"}, {"features", std::move(features)}}.dump(1) +
         "\n";
}

// A pixel for each cell.
absl::StatusOr<std::string> DrawMask(const PlanningMap& planning) {
  const grid::GridGeometry& geometry = planning.map.geometry;
  grid::PixelImage image{.width = geometry.width, .height = geometry.height, .channels = 1, .samples = {}};
  image.samples.reserve(planning.sources.size());
  for (int row = geometry.height - 1; row >= 0; --row) {  // pictures begin at the top
    for (int column = 0; column < geometry.width; ++column) {
      image.samples.push_back(static_cast<std::uint8_t>(planning.sources[geometry.index(column, row)]));
    }
  }
  return grid::EncodePng(image);
}

}  // namespace

std::string_view NameOf(Sight sight) {
  switch (sight) {
    case Sight::kSeen:
      return "seen";
    case Sight::kUnseen:
      return "unseen";
    case Sight::kContradicted:
      return "contradicted";
  }
  return "";
}

std::vector<grid::MapFile> CorrectedFiles(const PlanGraph& plan, const PlanFit& fit) {
  const PlanGraph graph = CorrectedGraph(plan, *fit.corrected);
  return {{"walls.geojson", WriteCorrectedWalls(plan, fit)},
          {"report.json", WriteReport(plan, fit)},
          {"walls.svg", WriteSvgPlan(graph)},
          {"walls.building.yaml", WriteBuildingPlan(graph, "plan", 1.0)}};
}

absl::StatusOr<std::vector<grid::MapFile>> PlanningFiles(const PlanGraph& plan, const PlanFit& fit,
                                                         grid::MapFileFormat format) {
  ENFILADE_ASSIGN_OR_RETURN(const PlanningMap planning, MakePlanningMap(fit.map, *fit.evidence, plan, *fit.corrected));
  ENFILADE_ASSIGN_OR_RETURN(std::vector<grid::MapFile> files,
                            grid::RenderFiles(grid::FromOccupancyGrid(planning.map), "planning", {.format = format}));
  ENFILADE_ASSIGN_OR_RETURN(std::string mask, DrawMask(planning));
  files.push_back({"planning-mask.png", std::move(mask)});
  return files;
}

absl::StatusOr<grid::MapFile> PictureFile(const PlanGraph& plan, const PlanFit& fit) {
  const PlanTransform& T_map_sheet = fit.alignment.T_map_sheet;
  const CorrectedPlan& corrected = *fit.corrected;
  plot::Scene scene;
  scene.rasters.push_back({.grid = fit.map, .T_scene_map = {}, .color = {90, 90, 90}});
  for (const PlanWall& wall : plan.walls) {
    const Eigen::Vector2d from = T_map_sheet(plan.corners[static_cast<std::size_t>(wall.from)].point);
    const Eigen::Vector2d to = T_map_sheet(plan.corners[static_cast<std::size_t>(wall.to)].point);
    scene.lines.push_back({.points = {from, to}, .color = {190, 190, 190}, .width_px = 1});
  }
  for (std::size_t i = 0; i < plan.walls.size(); ++i) {
    const Eigen::Vector2d from = corrected.corners()[static_cast<std::size_t>(plan.walls[i].from)].point;
    const Eigen::Vector2d to = corrected.corners()[static_cast<std::size_t>(plan.walls[i].to)].point;
    scene.lines.push_back({.points = {from, to}, .color = ColorOf(corrected.walls()[i].sight), .width_px = 2});
  }
  for (const AddedWall& wall : fit.added) {
    scene.lines.push_back({.points = {wall.from, wall.to}, .color = kOrange, .width_px = 2});
  }
  ENFILADE_ASSIGN_OR_RETURN(const plot::SceneView view, plot::ViewOf(scene, kPlotSide));
  ENFILADE_ASSIGN_OR_RETURN(std::string png, grid::EncodePng(plot::DrawScene(scene, view)));
  return grid::MapFile{"fit.png", std::move(png)};
}

}  // namespace enfilade::prior
