// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>

namespace enfilade {

// Twice the area of the triangle p, q, r: positive if r lies to the left of the way from p to q.
inline double SideOf(const Eigen::Vector2d& p, const Eigen::Vector2d& q, const Eigen::Vector2d& r) {
  return (q.x() - p.x()) * (r.y() - p.y()) - (q.y() - p.y()) * (r.x() - p.x());
}

// Whether the ends of each of the segments a-b and c-d lie on both sides of the other; touching is not crossing.
inline bool SegmentsCross(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c,
                          const Eigen::Vector2d& d) {
  return SideOf(a, b, c) * SideOf(a, b, d) < 0.0 && SideOf(c, d, a) * SideOf(c, d, b) < 0.0;
}

// m, from the point to the nearest point of the segment a-b.
inline double DistanceToSegment(const Eigen::Vector2d& point, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector2d along = b - a;
  const double share = std::clamp((point - a).dot(along) / std::max(along.squaredNorm(), 1e-12), 0.0, 1.0);
  return (point - a - share * along).norm();
}

// m, between the nearest points of the segments a-b and c-d: 0 if they cross.
inline double SegmentDistance(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c,
                              const Eigen::Vector2d& d) {
  if (SegmentsCross(a, b, c, d)) return 0.0;
  return std::min(
      {DistanceToSegment(a, c, d), DistanceToSegment(b, c, d), DistanceToSegment(c, a, b), DistanceToSegment(d, a, b)});
}

}  // namespace enfilade
