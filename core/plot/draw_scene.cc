// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "core/plot/scene.h"

namespace enfilade::plot {
namespace {

constexpr grid::Rgb kWhite{255, 255, 255};

void Multiply(grid::RgbImage& image, int column, int row, grid::Rgb color) {
  const std::size_t offset =
      3 * (static_cast<std::size_t>(row) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(column));
  for (std::size_t i = 0; i < color.size(); ++i) {
    image.samples[offset + i] = static_cast<std::uint8_t>(image.samples[offset + i] * color[i] / 255);
  }
}

// The most occupied cell under a pixel, sampled at `samples`^2 points, so that thin walls stay visible; unknown if all
// are.
std::uint8_t CellUnder(const grid::OccupancyGrid& grid, const Pose2& T_grid_scene, const SceneView& view,
                       const Eigen::Vector2d& pixel, int samples) {
  std::uint8_t cell = grid::kUnknownCell;
  for (int i = 0; i < samples * samples; ++i) {
    const int row = i / samples;
    const Eigen::Vector2d offset((i % samples + 0.5) / samples, (row + 0.5) / samples);
    const Eigen::Vector2d p_grid = T_grid_scene * view.ToScene(pixel + offset) / grid.geometry.resolution;
    const Eigen::Vector2d corner = p_grid.array().floor();
    if (corner.x() < 0.0 || corner.y() < 0.0 || corner.x() >= grid.geometry.width ||
        corner.y() >= grid.geometry.height) {
      continue;
    }
    cell = std::max(cell, grid.cells[grid.geometry.index(static_cast<int>(corner.x()), static_cast<int>(corner.y()))]);
  }
  return cell;
}

void Draw(const SceneRaster& raster, const SceneView& view, grid::RgbImage& image) {
  const grid::GridGeometry& geometry = raster.grid.geometry;
  const Pose2 T_scene_grid = raster.T_scene_map * geometry.T_map_grid;
  const Pose2 T_grid_scene = Inverse(T_scene_grid);
  Eigen::Vector2d low(image.width, image.height);
  Eigen::Vector2d high(0.0, 0.0);
  for (const double x : {0.0, geometry.width * geometry.resolution}) {
    for (const double y : {0.0, geometry.height * geometry.resolution}) {
      const Eigen::Vector2d pixel = view.ToPixel(T_scene_grid * Eigen::Vector2d(x, y));
      low = low.cwiseMin(pixel);
      high = high.cwiseMax(pixel);
    }
  }
  const int samples = std::clamp(static_cast<int>(std::ceil(1.0 / (view.px_per_m * geometry.resolution))), 1, 16);
  const int last_row = static_cast<int>(std::min<double>(image.height - 1, high.y()));
  const int last_column = static_cast<int>(std::min<double>(image.width - 1, high.x()));
  for (int row = static_cast<int>(std::max(0.0, low.y())); row <= last_row; ++row) {
    for (int column = static_cast<int>(std::max(0.0, low.x())); column <= last_column; ++column) {
      const std::uint8_t cell = CellUnder(raster.grid, T_grid_scene, view, Eigen::Vector2d(column, row), samples);
      if (cell != grid::kUnknownCell) Multiply(image, column, row, ColorOfCell(cell, raster.color));
    }
  }
}

void DrawPoints(const std::vector<Eigen::Vector2d>& points, const SceneView& view, grid::Rgb color, int width,
                grid::RgbImage& image) {
  const Eigen::Vector2d half(0.5, 0.5);  // DrawLine measures from pixel centres
  for (std::size_t i = 1; i < points.size(); ++i) {
    grid::DrawLine(image, view.ToPixel(points[i - 1]) - half, view.ToPixel(points[i]) - half, color, width);
  }
}

void Draw(const SceneMarker& marker, const SceneView& view, grid::RgbImage& image) {
  const Eigen::Vector2d at = view.ToPixel(marker.at) - Eigen::Vector2d(0.5, 0.5);
  if (marker.shape == SceneMarker::Shape::kCross) {
    grid::DrawLine(image, at + Eigen::Vector2d(-5, -5), at + Eigen::Vector2d(5, 5), marker.color, 2);
    grid::DrawLine(image, at + Eigen::Vector2d(-5, 5), at + Eigen::Vector2d(5, -5), marker.color, 2);
    return;
  }
  if (marker.shape == SceneMarker::Shape::kSquare) {
    for (int dy = -4; dy <= 4; ++dy) {
      grid::DrawLine(image, at + Eigen::Vector2d(-4, dy), at + Eigen::Vector2d(4, dy), marker.color, 1);
    }
    return;
  }
  constexpr int kRadius = 5;
  for (int dy = -kRadius; dy <= kRadius; ++dy) {
    const double dx = std::sqrt(kRadius * kRadius - dy * dy);
    grid::DrawLine(image, at + Eigen::Vector2d(-dx, dy), at + Eigen::Vector2d(dx, dy), marker.color, 1);
  }
  if (marker.shape == SceneMarker::Shape::kDot) return;
  for (int dy = -2; dy <= 2; ++dy) {
    grid::DrawLine(image, at + Eigen::Vector2d(-2, dy), at + Eigen::Vector2d(2, dy), kWhite, 1);
  }
}

}  // namespace

grid::RgbImage DrawScene(const Scene& scene, const SceneView& view) {
  grid::RgbImage image(view.width, view.height, kWhite);
  for (const SceneRaster& raster : scene.rasters) Draw(raster, view, image);
  for (const SceneLine& line : scene.lines) DrawPoints(line.points, view, line.color, line.width_px, image);
  for (const SceneEllipse& ellipse : scene.ellipses) DrawPoints(Outline(ellipse), view, ellipse.color, 2, image);
  for (const SceneMarker& marker : scene.markers) Draw(marker, view, image);
  return image;
}

}  // namespace enfilade::plot
