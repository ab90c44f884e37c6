// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

namespace enfilade::prior {

// A straight piece of wall in a map.
struct FittedLine {
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();  // m, of the points
  Eigen::Vector2d along = Eigen::Vector2d::Zero();   // unit, either way
  double least = 0;                                  // m, from `middle`: where the points begin and end
  double most = 0;

  double length() const { return most - least; }
  Eigen::Vector2d from() const { return middle + least * along; }
  Eigen::Vector2d to() const { return middle + most * along; }
  // m, to the left of the line if one looks along it.
  double OffsetOf(const Eigen::Vector2d& point) const {
    return Eigen::Vector2d(-along.y(), along.x()).dot(point - middle);
  }
};

// By total least squares. `points`: two at least.
FittedLine FitLine(const std::vector<Eigen::Vector2d>& points);

}  // namespace enfilade::prior
