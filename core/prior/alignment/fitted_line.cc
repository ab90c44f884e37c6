// SPDX-License-Identifier: Apache-2.0
#include "core/prior/alignment/fitted_line.h"

#include <Eigen/Eigenvalues>
#include <algorithm>

namespace enfilade::prior {

FittedLine FitLine(const std::vector<Eigen::Vector2d>& points) {
  FittedLine line;
  for (const Eigen::Vector2d& point : points) line.middle += point / static_cast<double>(points.size());
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const Eigen::Vector2d& point : points) scatter += (point - line.middle) * (point - line.middle).transpose();
  line.along = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(scatter).eigenvectors().col(1);
  for (const Eigen::Vector2d& point : points) {
    const double at = line.along.dot(point - line.middle);
    line.least = std::min(line.least, at);
    line.most = std::max(line.most, at);
  }
  return line;
}

}  // namespace enfilade::prior
