// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/geometry/pose2.h"
#include "core/grid/files/rgb_image.h"
#include "core/grid/occupancy_grid.h"

namespace enfilade::plot {

// The content of a plot in one frame (the scene's; m, y upwards). Later elements are drawn over earlier ones. Rasters
// lie below everything else and are multiplied together, so overlapping maps all stay visible.

// Free cells pale, occupied ones dark in `color`; unknown ones are transparent.
struct SceneRaster {
  grid::OccupancyGrid grid;
  Pose2 T_scene_map;
  grid::Rgb color{};
};

struct SceneLine {
  std::vector<Eigen::Vector2d> points;
  grid::Rgb color{};
  int width_px = 1;
};

// A circle if both semi-axes are equal.
struct SceneEllipse {
  Eigen::Vector2d center;
  double semi_major_m = 0.0;
  double semi_minor_m = 0.0;
  double angle = 0.0;  // of the larger axis from the x axis, rad
  grid::Rgb color{};
};

struct SceneMarker {
  enum class Shape : std::uint8_t { kDot, kRing, kCross, kSquare };
  Eigen::Vector2d at;
  Shape shape = Shape::kDot;
  grid::Rgb color{};
};

// Text to the right of its point. SVG only.
struct SceneLabel {
  Eigen::Vector2d at;
  std::string text;  // UTF-8
  grid::Rgb color{};
};

struct Scene {
  std::vector<SceneRaster> rasters{};
  std::vector<SceneLine> lines{};
  std::vector<SceneEllipse> ellipses{};
  std::vector<SceneMarker> markers{};
  std::vector<SceneLabel> labels{};
};

// The mapping from the scene to pixels: (0, 0) is the picture's upper left corner, y downwards.
struct SceneView {
  Eigen::Vector2d upper_left;  // in the scene
  double px_per_m = 1.0;
  int width = 0;
  int height = 0;

  Eigen::Vector2d ToPixel(const Eigen::Vector2d& p) const {
    return {(p.x() - upper_left.x()) * px_per_m, (upper_left.y() - p.y()) * px_per_m};
  }
  Eigen::Vector2d ToScene(const Eigen::Vector2d& pixel) const {
    return {upper_left.x() + pixel.x() / px_per_m, upper_left.y() - pixel.y() / px_per_m};
  }
};

// Shows the whole scene with a margin; the longer side has `longer_side_px` pixels. INVALID_ARGUMENT: an empty scene, a
// position that is not finite, a side below 64 or above 16384.
absl::StatusOr<SceneView> ViewOf(const Scene& scene, int longer_side_px);

// 72 points around the ellipse, the first repeated at the end.
std::vector<Eigen::Vector2d> Outline(const SceneEllipse& ellipse);

// The colour of a known cell, as described at SceneRaster.
grid::Rgb ColorOfCell(std::uint8_t cell, grid::Rgb color);

grid::RgbImage DrawScene(const Scene& scene, const SceneView& view);

// SVG 1.1 with the grids as embedded PNG.
absl::StatusOr<std::string> WriteSvg(const Scene& scene, const SceneView& view);

}  // namespace enfilade::plot
