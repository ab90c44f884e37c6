// SPDX-License-Identifier: Apache-2.0
#include "core/grid/files/rgb_image.h"

#include <algorithm>
#include <cmath>

#include "core/grid/files/png_codec.h"

namespace enfilade::grid {
namespace {

constexpr Rgb kUnknownColor{196, 206, 214};

void PutPixel(RgbImage& image, int column, int row, Rgb color) {
  if (column < 0 || row < 0 || column >= image.width || row >= image.height) return;
  const std::size_t offset =
      (static_cast<std::size_t>(row) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(column)) * 3;
  std::copy(color.begin(), color.end(), image.samples.begin() + static_cast<std::ptrdiff_t>(offset));
}

// Clips the segment to the box [low, high]; false if nothing is left (Liang, Barsky, "A new concept and method for line
// clipping", 1984).
bool Clip(Eigen::Vector2d& from, Eigen::Vector2d& to, const Eigen::Vector2d& low, const Eigen::Vector2d& high) {
  const Eigen::Vector2d along = to - from;
  double begin = 0.0;
  double end = 1.0;
  for (int axis = 0; axis < 2; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      const double speed = side * along[axis];  // outwards
      const double room = side < 0.0 ? from[axis] - low[axis] : high[axis] - from[axis];
      if (speed == 0.0 && room < 0.0) return false;
      if (speed < 0.0) begin = std::max(begin, room / speed);
      if (speed > 0.0) end = std::min(end, room / speed);
    }
  }
  if (begin > end) return false;
  to = from + end * along;
  from += begin * along;
  return true;
}

}  // namespace

RgbImage::RgbImage(int image_width, int image_height, Rgb background) : width(image_width), height(image_height) {
  samples.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3);
  for (std::size_t i = 0; i < samples.size(); ++i) samples[i] = background[i % 3];
}

RgbImage DrawGrid(const OccupancyGrid& grid) {
  const GridGeometry& geometry = grid.geometry;
  RgbImage image(geometry.width, geometry.height, kUnknownColor);
  for (int row = 0; row < geometry.height; ++row) {
    const std::uint8_t* const cells = grid.cells.data() + geometry.index(0, geometry.height - 1 - row);
    for (int column = 0; column < geometry.width; ++column) {
      if (cells[column] == kUnknownCell) continue;
      const auto grey = static_cast<std::uint8_t>(255 - cells[column]);  // known cells: 1 is free, 255 occupied
      PutPixel(image, column, row, {grey, grey, grey});
    }
  }
  return image;
}

void DrawLine(RgbImage& image, Eigen::Vector2d from, Eigen::Vector2d to, Rgb color, int thickness) {
  if (!from.allFinite() || !to.allFinite()) return;
  const double margin = thickness + 1.0;
  if (!Clip(from, to, {-margin, -margin}, {image.width + margin, image.height + margin})) return;
  const auto pixel_of = [](const Eigen::Vector2d& p) {
    return CellIndex{static_cast<int>(std::lround(p.x())), static_cast<int>(std::lround(p.y()))};
  };
  const int before = (thickness - 1) / 2;
  VisitLine(pixel_of(from), pixel_of(to), [&](CellIndex pixel) {
    for (int row = 0; row < thickness; ++row) {
      for (int column = 0; column < thickness; ++column) {
        PutPixel(image, pixel.column - before + column, pixel.row - before + row, color);
      }
    }
  });
}

Eigen::Vector2d PixelOf(const GridGeometry& geometry, const Eigen::Vector2d& p_map) {
  const Eigen::Vector2d p_grid = Inverse(geometry.T_map_grid) * p_map / geometry.resolution;
  return {p_grid.x() - 0.5, geometry.height - 0.5 - p_grid.y()};
}

void DrawPath(RgbImage& image, const GridGeometry& geometry, std::span<const Eigen::Vector2d> path, Rgb color,
              int thickness) {
  for (std::size_t i = 1; i < path.size(); ++i) {
    DrawLine(image, PixelOf(geometry, path[i - 1]), PixelOf(geometry, path[i]), color, thickness);
  }
}

absl::StatusOr<std::string> EncodePng(const RgbImage& image) {
  return EncodePng(PixelRows{.width = image.width,
                             .height = image.height,
                             .channels = 3,
                             .top_row = image.samples.data(),
                             .stride = std::ptrdiff_t{image.width} * 3});
}

}  // namespace enfilade::grid
