// SPDX-License-Identifier: Apache-2.0
#include "core/geometry/convex_hull.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "core/geometry/segments.h"

namespace enfilade {
namespace {

using Eigen::Vector2d;

constexpr double kOnLine = 1e-9;  // twice the area of three points on one line, as they come from files

}  // namespace

// Andrew's monotone chain (1979).
ConvexHull::ConvexHull(std::vector<Vector2d> points) {
  const auto before = [](const Vector2d& a, const Vector2d& b) {
    return std::pair(a.x(), a.y()) < std::pair(b.x(), b.y());
  };
  std::sort(points.begin(), points.end(), before);
  const auto add = [&](const Vector2d& p, std::size_t least) {
    while (outline_.size() >= least + 2 && SideOf(outline_[outline_.size() - 2], outline_.back(), p) <= kOnLine) {
      outline_.pop_back();
    }
    outline_.push_back(p);
  };
  for (const Vector2d& p : points) add(p, 0);
  if (outline_.size() < 2) return;
  const std::size_t lower = outline_.size() - 1;
  for (auto p = points.rbegin() + 1; p != points.rend(); ++p) add(*p, lower);
  outline_.pop_back();
}

double ConvexHull::Area() const {
  double sum = 0;
  for (std::size_t i = 2; i < outline_.size(); ++i) sum += SideOf(outline_[0], outline_[i - 1], outline_[i]) / 2;
  return sum;
}

bool ConvexHull::Contains(const Vector2d& point, double margin) const {
  if (outline_.size() < 3) return false;
  for (std::size_t i = 0; i < outline_.size(); ++i) {
    const Vector2d& a = outline_[i];
    const Vector2d& b = outline_[(i + 1) % outline_.size()];
    if (SideOf(a, b, point) < -margin * (b - a).norm()) return false;
  }
  return true;
}

}  // namespace enfilade
