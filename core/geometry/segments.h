// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

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

}  // namespace enfilade
