// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

namespace enfilade {

// What lies around some points. Immutable.
class ConvexHull {
 public:
  explicit ConvexHull(std::vector<Eigen::Vector2d> points);

  // Its corners, turning from x to y; fewer than three if the points lie on one line.
  const std::vector<Eigen::Vector2d>& outline() const { return outline_; }
  double Area() const;
  // Whether a point lies within the hull or up to `margin` outside one of its sides.
  bool Contains(const Eigen::Vector2d& point, double margin) const;

 private:
  std::vector<Eigen::Vector2d> outline_;
};

}  // namespace enfilade
