// SPDX-License-Identifier: Apache-2.0
#include "core/plot/scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/error.h"

namespace enfilade::plot {
namespace {

constexpr double kPale = 0.22;  // share of its colour that free ground has

class Bounds {
 public:
  void Add(const Eigen::Vector2d& p) {
    low_ = empty_ ? p : Eigen::Vector2d(low_.cwiseMin(p));
    high_ = empty_ ? p : Eigen::Vector2d(high_.cwiseMax(p));
    finite_ = finite_ && p.allFinite();
    empty_ = false;
  }
  bool empty() const { return empty_; }
  bool finite() const { return finite_; }
  const Eigen::Vector2d& low() const { return low_; }
  const Eigen::Vector2d& high() const { return high_; }

 private:
  bool empty_ = true;
  bool finite_ = true;
  Eigen::Vector2d low_{0.0, 0.0};
  Eigen::Vector2d high_{0.0, 0.0};
};

Bounds BoundsOf(const Scene& scene) {
  Bounds bounds;
  for (const SceneRaster& raster : scene.rasters) {
    const grid::GridGeometry& geometry = raster.grid.geometry;
    const Pose2 T_scene_grid = raster.T_scene_map * geometry.T_map_grid;
    for (const double x : {0.0, geometry.width * geometry.resolution}) {
      for (const double y : {0.0, geometry.height * geometry.resolution}) {
        bounds.Add(T_scene_grid * Eigen::Vector2d(x, y));
      }
    }
  }
  for (const SceneLine& line : scene.lines) {
    for (const Eigen::Vector2d& p : line.points) bounds.Add(p);
  }
  for (const SceneEllipse& ellipse : scene.ellipses) {
    for (const Eigen::Vector2d& p : Outline(ellipse)) bounds.Add(p);
  }
  for (const SceneMarker& marker : scene.markers) bounds.Add(marker.at);
  for (const SceneLabel& label : scene.labels) bounds.Add(label.at);
  return bounds;
}

}  // namespace

absl::StatusOr<SceneView> ViewOf(const Scene& scene, int longer_side_px) {
  if (longer_side_px < 64 || longer_side_px > 16384) {
    return InvalidArgument("a picture of {} pixels: expected 64 to 16384", longer_side_px);
  }
  const Bounds bounds = BoundsOf(scene);
  if (bounds.empty()) return InvalidArgument("the scene is empty");
  if (!bounds.finite()) return InvalidArgument("the scene has a position that is not finite");
  const Eigen::Vector2d size = bounds.high() - bounds.low();
  const double margin = std::max(0.03 * size.maxCoeff(), 0.5);
  const Eigen::Vector2d framed = size + Eigen::Vector2d::Constant(2.0 * margin);
  SceneView view;
  view.upper_left = {bounds.low().x() - margin, bounds.high().y() + margin};
  view.px_per_m = longer_side_px / framed.maxCoeff();
  view.width = std::max(1, static_cast<int>(std::lround(framed.x() * view.px_per_m)));
  view.height = std::max(1, static_cast<int>(std::lround(framed.y() * view.px_per_m)));
  return view;
}

std::vector<Eigen::Vector2d> Outline(const SceneEllipse& ellipse) {
  constexpr int kPoints = 72;
  const Pose2 T_scene_ellipse{ellipse.center.x(), ellipse.center.y(), ellipse.angle};
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i <= kPoints; ++i) {
    const double angle = 2.0 * std::numbers::pi * (i % kPoints) / kPoints;
    points.push_back(T_scene_ellipse *
                     Eigen::Vector2d(ellipse.semi_major_m * std::cos(angle), ellipse.semi_minor_m * std::sin(angle)));
  }
  return points;
}

grid::Rgb ColorOfCell(std::uint8_t cell, grid::Rgb color) {
  const double occupied = grid::ProbabilityOfCell(cell);
  grid::Rgb result;
  for (std::size_t i = 0; i < result.size(); ++i) {
    const double pale = 255.0 - kPale * (255.0 - color[i]);
    const double dark = 0.5 * color[i];
    result[i] = static_cast<std::uint8_t>(std::lround(pale + occupied * (dark - pale)));
  }
  return result;
}

}  // namespace enfilade::plot
