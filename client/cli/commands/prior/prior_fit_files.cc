// SPDX-License-Identifier: Apache-2.0
#include "client/cli/commands/prior/prior_fit_files.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/grid/files/png_codec.h"
#include "core/plot/scene.h"
#include "fmt/format.h"
#include "io/file.h"
#include "nlohmann/json.hpp"

namespace enfilade::cli {
namespace {

constexpr int kPlotSide = 1600;

absl::StatusOr<std::vector<std::vector<double>>> ReadRows(const std::filesystem::path& path, std::size_t columns) {
  ENFILADE_ASSIGN_OR_RETURN(const std::string text, io::ReadFile(path));
  std::vector<std::vector<double>> rows;
  int number = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    std::string line = text.substr(begin, end - begin);
    begin = end + 1;
    ++number;
    std::erase_if(line, [](char c) { return c == ' ' || c == '\t' || c == '\r'; });
    if (line.empty() || line.front() == '#') continue;
    std::vector<double> row;
    for (const char* at = line.data();;) {
      const char* const last = line.data() + line.size();
      double value = 0;
      const auto [next, error] = std::from_chars(at, last, value);
      if (error != std::errc{} || !std::isfinite(value))
        return InvalidArgument("{}: line {}: not a number", path.string(), number);
      row.push_back(value);
      if (next == last) break;
      if (*next != ',') return InvalidArgument("{}: line {}: not a number", path.string(), number);
      at = next + 1;
    }
    if (row.size() != columns) {
      return InvalidArgument("{}: line {}: {} numbers, {} are needed", path.string(), number, row.size(), columns);
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

grid::Rgb ColorOf(prior::Sight sight) {
  switch (sight) {
    case prior::Sight::kSeen:
      return grid::kGreen;
    case prior::Sight::kUnseen:
      return grid::kBlue;
    case prior::Sight::kContradicted:
      return grid::kRed;
  }
  return grid::kBlue;
}

nlohmann::json Position(const Eigen::Vector2d& point) { return {point.x(), point.y()}; }

}  // namespace

absl::StatusOr<std::vector<prior::ControlPair>> ReadPairs(const std::filesystem::path& path) {
  ENFILADE_ASSIGN_OR_RETURN(const auto rows, ReadRows(path, 4));
  std::vector<prior::ControlPair> pairs;
  for (const std::vector<double>& row : rows) pairs.push_back({{row[0], row[1]}, {row[2], row[3]}});
  return pairs;
}

absl::StatusOr<std::vector<Eigen::Vector2d>> ReadSheetPoints(const std::filesystem::path& path) {
  ENFILADE_ASSIGN_OR_RETURN(const auto rows, ReadRows(path, 2));
  std::vector<Eigen::Vector2d> points;
  for (const std::vector<double>& row : rows) points.emplace_back(row[0], row[1]);
  return points;
}

std::string_view NameOf(prior::Sight sight) {
  switch (sight) {
    case prior::Sight::kSeen:
      return "seen";
    case prior::Sight::kUnseen:
      return "unseen";
    case prior::Sight::kContradicted:
      return "contradicted";
  }
  return "";
}

std::string WriteCorrectedPlan(const prior::PlanGraph& plan, const prior::CorrectedPlan& corrected) {
  nlohmann::json features = nlohmann::json::array();
  for (std::size_t i = 0; i < plan.walls.size(); ++i) {
    const prior::CorrectedCorner& from = corrected.corners()[static_cast<std::size_t>(plan.walls[i].from)];
    const prior::CorrectedCorner& to = corrected.corners()[static_cast<std::size_t>(plan.walls[i].to)];
    const prior::CorrectedWall& wall = corrected.walls()[i];
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
           {"sigma_m", std::sqrt(std::max(0.0, variance))}}}});
  }
  return nlohmann::json{{"type", "FeatureCollection"}, {"frame", "metres"}, {"features", std::move(features)}}.dump(1) +
         "\n";
}

std::string WriteLocatedPoints(const std::vector<Eigen::Vector2d>& points, const prior::CorrectedPlan& corrected) {
  std::string text = "plan_x_px,plan_y_px,input_x_m,input_y_m,sigma_m,state\n";
  for (const Eigen::Vector2d& point : points) {
    const prior::CorrectedPoint located = corrected.Locate(point);
    text += fmt::format("{},{},{:.4f},{:.4f},{:.4f},{}\n", point.x(), point.y(), located.point.x(), located.point.y(),
                        located.sigma, NameOf(located.sight));
  }
  return text;
}

absl::StatusOr<std::string> DrawFit(const grid::OccupancyGrid& map, const prior::PlanGraph& plan,
                                    const prior::PlanTransform& T_map_sheet, const prior::CorrectedPlan& corrected) {
  plot::Scene scene;
  scene.rasters.push_back({.grid = map, .T_scene_map = {}, .color = {90, 90, 90}});
  for (const prior::PlanWall& wall : plan.walls) {
    const Eigen::Vector2d from = T_map_sheet(plan.corners[static_cast<std::size_t>(wall.from)].point);
    const Eigen::Vector2d to = T_map_sheet(plan.corners[static_cast<std::size_t>(wall.to)].point);
    scene.lines.push_back({.points = {from, to}, .color = {190, 190, 190}, .width_px = 1});
  }
  for (std::size_t i = 0; i < plan.walls.size(); ++i) {
    const Eigen::Vector2d from = corrected.corners()[static_cast<std::size_t>(plan.walls[i].from)].point;
    const Eigen::Vector2d to = corrected.corners()[static_cast<std::size_t>(plan.walls[i].to)].point;
    scene.lines.push_back({.points = {from, to}, .color = ColorOf(corrected.walls()[i].sight), .width_px = 2});
  }
  ENFILADE_ASSIGN_OR_RETURN(const plot::SceneView view, plot::ViewOf(scene, kPlotSide));
  return grid::EncodePng(plot::DrawScene(scene, view));
}

absl::StatusOr<std::string> DrawMask(const prior::PlanningMap& planning) {
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

}  // namespace enfilade::cli
