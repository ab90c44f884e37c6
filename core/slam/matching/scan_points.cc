// SPDX-License-Identifier: Apache-2.0
#include "core/slam/matching/scan_points.h"

#include <cmath>
#include <cstddef>

namespace enfilade::slam {
namespace {

constexpr std::size_t kNeighbours = 4;  // points on either side that show how the surface runs
constexpr double kSameSurface = 0.3;    // m, from the point
constexpr double kLeastExtent = 0.1;    // m
constexpr double kStraight = 0.02;      // m, root mean square from a line

// Of the line through points[first] to points[last] (least squares). Zero if they are not on one, or near each other.
Eigen::Vector2d NormalOf(const std::vector<Eigen::Vector2d>& points, std::size_t first, std::size_t last) {
  const auto count = static_cast<double>(last - first + 1);
  if (count < 3.0 || (points[last] - points[first]).norm() < kLeastExtent) return Eigen::Vector2d::Zero();
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (std::size_t i = first; i <= last; ++i) mean += points[i] / count;
  double xx = 0.0;
  double yy = 0.0;
  double xy = 0.0;
  for (std::size_t i = first; i <= last; ++i) {
    const Eigen::Vector2d d = points[i] - mean;
    xx += d.x() * d.x() / count;
    yy += d.y() * d.y() / count;
    xy += d.x() * d.y() / count;
  }
  const double across2 = 0.5 * (xx + yy - std::hypot(xx - yy, 2.0 * xy));  // m^2, the least eigenvalue
  if (across2 > kStraight * kStraight) return Eigen::Vector2d::Zero();
  const double along = 0.5 * std::atan2(2.0 * xy, xx - yy);
  return {-std::sin(along), std::cos(along)};
}

}  // namespace

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

std::vector<Eigen::Vector2d> SurfaceNormals(const std::vector<Eigen::Vector2d>& points) {
  std::vector<Eigen::Vector2d> normals;
  normals.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto is_same = [&](std::size_t k) { return (points[k] - points[i]).norm() < kSameSurface; };
    std::size_t first = i;
    std::size_t last = i;
    while (first > 0 && i - first < kNeighbours && is_same(first - 1)) --first;
    while (last + 1 < points.size() && last - i < kNeighbours && is_same(last + 1)) ++last;
    normals.push_back(NormalOf(points, first, last));
  }
  return normals;
}

}  // namespace enfilade::slam
