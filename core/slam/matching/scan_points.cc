// SPDX-License-Identifier: Apache-2.0
#include "core/slam/matching/scan_points.h"

namespace enfilade::slam {

std::vector<Eigen::Vector2d> Thinned(const std::vector<Eigen::Vector2d>& points, double spacing) {
  std::vector<Eigen::Vector2d> kept;
  kept.reserve(points.size());
  for (const Eigen::Vector2d& p : points) {
    if (kept.empty() || (p - kept.back()).squaredNorm() >= spacing * spacing) kept.push_back(p);
  }
  return kept;
}

std::vector<Eigen::Vector2d> Subsampled(const std::vector<Eigen::Vector2d>& points, std::size_t count) {
  const std::size_t step = (points.size() + count - 1) / count;
  if (step <= 1) return points;
  std::vector<Eigen::Vector2d> kept;
  for (std::size_t i = 0; i < points.size(); i += step) kept.push_back(points[i]);
  return kept;
}

}  // namespace enfilade::slam
