// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

namespace enfilade::perception {

// What lies around some points.
class ConvexHull {
 public:
  explicit ConvexHull(std::vector<Eigen::Vector2d> points);

  double Area() const;
  // Whether a point lies within the hull or up to `margin` outside one of its sides.
  bool Contains(const Eigen::Vector2d& point, double margin) const;

 private:
  std::vector<Eigen::Vector2d> outline_;  // turning from x to y
};

}  // namespace enfilade::perception
