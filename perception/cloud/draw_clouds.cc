// SPDX-License-Identifier: Apache-2.0
#include "perception/cloud/draw_clouds.h"

#include <algorithm>
#include <cmath>

namespace enfilade::perception {
namespace {

constexpr double kSide = 1000.0;  // pixels
constexpr double kTail = 0.005;   // share of points outside the frame on each side: outliers

// From the kTail to the 1 - kTail quantile of one coordinate.
std::pair<double, double> Extent(const Cloud& cloud, Eigen::Index axis) {
  std::vector<float> values;
  values.reserve(cloud.points.size());
  for (const Eigen::Vector3f& point : cloud.points) values.push_back(point[axis]);
  std::sort(values.begin(), values.end());
  const auto last = static_cast<double>(values.size() - 1);
  return {values[static_cast<std::size_t>(kTail * last)], values[static_cast<std::size_t>((1.0 - kTail) * last)]};
}

}  // namespace

grid::RgbImage DrawClouds(const Cloud& source, const Cloud& target, const Eigen::Isometry3d& T_target_source) {
  const Cloud below = FinitePoints(target);
  const Cloud above = Transformed(FinitePoints(source), T_target_source);
  Cloud all = below;
  all.points.insert(all.points.end(), above.points.begin(), above.points.end());
  if (all.points.empty()) return {1, 1, {255, 255, 255}};
  const auto [min_x, max_x] = Extent(all, 0);
  const auto [min_y, max_y] = Extent(all, 1);
  const double left = min_x;
  const double top = max_y;
  const double scale = (kSide - 1.0) / std::max({max_x - min_x, max_y - min_y, 1e-3});
  grid::RgbImage picture(1 + static_cast<int>((max_x - min_x) * scale), 1 + static_cast<int>((max_y - min_y) * scale),
                         {255, 255, 255});
  const auto draw = [&](const Cloud& cloud, grid::Rgb color) {
    for (const Eigen::Vector3f& point : cloud.points) {
      const Eigen::Vector2d pixel((point.x() - left) * scale, (top - point.y()) * scale);
      grid::DrawLine(picture, pixel, pixel, color);
    }
  };
  draw(below, grid::kBlue);
  draw(above, grid::kRed);
  return picture;
}

}  // namespace enfilade::perception
