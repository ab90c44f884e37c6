// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/support/plan_truth.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/geometry/segments.h"
#include "core/prior/plan/segment_grid.h"
#include "io/file.h"
#include "perception/plan/opencv_tracing.h"
#include "yaml-cpp/yaml.h"

namespace enfilade::bench {
namespace {

using Eigen::Vector2d;

constexpr grid::Rgb kFoundInk = grid::kGreen, kFalseInk = grid::kRed, kMissedInk = grid::kBlue;

}  // namespace

absl::StatusOr<std::vector<PicturedLevel>> FindPicturedLevels(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().string().ends_with(".building.yaml")) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  std::vector<PicturedLevel> levels;
  for (const std::filesystem::path& file : files) {
    const YAML::Node building = YAML::LoadFile(file.string());
    const std::string name = file.stem().stem().string();
    for (const auto& level : building["levels"]) {
      if (!level.second["drawing"]) continue;
      const std::filesystem::path picture = folder / level.second["drawing"]["filename"].as<std::string>();
      if (picture.extension() != ".png" || !std::filesystem::exists(picture)) continue;
      const std::string level_name = level.first.as<std::string>();
      ENFILADE_ASSIGN_OR_RETURN(prior::PlanGraph truth, perception::ReadPlan(file, {.level = level_name}));
      levels.push_back({name + " " + level_name, picture, std::move(truth)});
    }
  }
  if (levels.empty()) return NotFound("{}: no building.yaml with a picture", folder.string());
  return levels;
}

double ShareDrawn(const prior::PlanGraph& plan, const perception::GreyFrame& picture,
                  const testing::PlanTolerance& tolerance) {
  constexpr int kDark = 160;
  const int reach = static_cast<int>(std::ceil(tolerance.distance));
  int all = 0, drawn = 0;
  for (const prior::PlanWall& wall : plan.walls) {
    const Vector2d a = plan.corners[wall.from].point, b = plan.corners[wall.to].point;
    const int samples = std::max(1, static_cast<int>((b - a).norm() / tolerance.step));
    for (int k = 0; k < samples; ++k) {
      const Vector2d p = a + (b - a) * ((k + 0.5) / samples);
      bool dark = false;
      for (int y = static_cast<int>(p.y()) - reach; y <= static_cast<int>(p.y()) + reach; ++y) {
        for (int x = static_cast<int>(p.x()) - reach; x <= static_cast<int>(p.x()) + reach; ++x) {
          if (x < 0 || y < 0 || x >= picture.width || y >= picture.height) continue;
          dark = dark || (picture.pixels[static_cast<std::size_t>(y) * picture.width + x] < kDark &&
                          (Vector2d(x, y) - p).norm() <= tolerance.distance);
        }
      }
      ++all;
      drawn += dark ? 1 : 0;
    }
  }
  return all > 0 ? static_cast<double>(drawn) / all : 0;
}

grid::RgbImage DrawDifferences(const perception::PlanFile& found, const prior::PlanGraph& truth,
                               const testing::PlanTolerance& tolerance) {
  const perception::GreyFrame& picture = *found.picture;
  const int enlarged = std::max(1, 1600 / std::max(picture.width, picture.height));
  grid::RgbImage image(picture.width * enlarged, picture.height * enlarged, {255, 255, 255});
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const std::size_t from = static_cast<std::size_t>(y / enlarged) * picture.width + x / enlarged;
      std::fill_n(&image.samples[3 * (static_cast<std::size_t>(y) * image.width + x)], 3,
                  static_cast<std::uint8_t>(170 + picture.pixels[from] / 3));
    }
  }
  const Vector2d middle = Vector2d::Constant((enlarged - 1) / 2.0);
  const auto line = [&](const Vector2d& a, const Vector2d& b, grid::Rgb color, int thickness) {
    grid::DrawLine(image, enlarged * a + middle, enlarged * b + middle, color, thickness);
  };
  for (const prior::PlanWall& wall : found.graph.walls) {
    line(found.graph.corners[wall.from].point, found.graph.corners[wall.to].point, kFoundInk, 2);
  }
  for (const Vector2d& p : testing::SamplesOffWalls(found.graph, truth, tolerance)) line(p, p, kFalseInk, 5);
  for (const Vector2d& p : testing::SamplesOffWalls(truth, found.graph, tolerance)) line(p, p, kMissedInk, 5);
  for (const prior::PlanDoor& door : found.graph.doors) line(door.from, door.to, kFalseInk, 1);
  for (const prior::PlanDoor& door : truth.doors) line(door.from, door.to, kMissedInk, 1);
  return image;
}

absl::StatusOr<double> ShareOfStrokes(const std::string& bytes, const prior::PlanGraph& plan) {
  ENFILADE_ASSIGN_OR_RETURN(const perception::Sheet sheet, perception::DecodeSheet(bytes));
  const perception::StrokeGraph strokes = perception::TraceStrokes(perception::FindInk(sheet));
  prior::SegmentGrid grid(20);
  for (std::size_t i = 0; i < plan.walls.size(); ++i) {
    grid.Add(static_cast<int>(i), plan.corners[plan.walls[i].from].point, plan.corners[plan.walls[i].to].point);
  }
  int all = 0, on_walls = 0;
  for (const perception::Stroke& stroke : strokes.strokes) {
    const Vector2d a = strokes.joints[stroke.from], b = strokes.joints[stroke.to];
    const int samples = static_cast<int>(std::ceil((b - a).norm() / 2));
    for (int k = 0; k < samples; ++k) {
      const Vector2d p = a + (b - a) * ((k + 0.5) / samples);
      bool on = false;
      grid.ForEachNear(p, p, [&](int id) {
        const prior::PlanWall& wall = plan.walls[id];
        const double far = DistanceToSegment(p, plan.corners[wall.from].point, plan.corners[wall.to].point);
        on = on || far <= std::max({3.0, wall.thickness / 2 + 1, stroke.width / 2 + 1});
      });
      ++all;
      on_walls += on ? 1 : 0;
    }
  }
  return all > 0 ? static_cast<double>(on_walls) / all : 0.0;
}

}  // namespace enfilade::bench
