// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/geometry/pose2.h"
#include "core/grid/bresenham.h"
#include "core/grid/occupancy_grid.h"

namespace enfilade::grid {

using Rgb = std::array<std::uint8_t, 3>;

constexpr Rgb kRed{214, 39, 40};
constexpr Rgb kBlue{31, 119, 180};
constexpr Rgb kGreen{44, 160, 44};

// A picture: maps with trajectories drawn over them. Pixel (0, 0) is at the upper left.
struct RgbImage {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> samples;  // 3 per pixel, rows from the top

  RgbImage(int width, int height, Rgb background);
};

// One pixel per cell: white free, black occupied, grey in between; unknown cells a light blue-grey.
RgbImage DrawGrid(const OccupancyGrid& grid);

// A line between the centres of two pixels, `thickness` pixels wide, clipped to the image.
void DrawLine(RgbImage& image, Eigen::Vector2d from, Eigen::Vector2d to, Rgb color, int thickness = 1);

// Connects the points (map frame, m) on the image of a grid with `geometry` (as from DrawGrid). Points that are not
// finite interrupt the path.
void DrawPath(RgbImage& image, const GridGeometry& geometry, std::span<const Eigen::Vector2d> path, Rgb color,
              int thickness = 1);

// The pixel of a point in the map's frame: column and row from the top, with fractions measured from the pixel's
// centre.
Eigen::Vector2d PixelOf(const GridGeometry& geometry, const Eigen::Vector2d& p_map);

absl::StatusOr<std::string> EncodePng(const RgbImage& image);

}  // namespace enfilade::grid
