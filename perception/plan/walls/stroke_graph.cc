// SPDX-License-Identifier: Apache-2.0
#include "perception/plan/walls/stroke_graph.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace enfilade::perception {

FittedLine FitLine(const Moments& moments) {
  const Eigen::Vector2d mean = moments.sum / std::max(moments.count, 1.0);
  const Eigen::Matrix2d spread = moments.squares / std::max(moments.count, 1.0) - mean * mean.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(spread);
  FittedLine line;
  line.normal = solver.eigenvectors().col(0);
  line.offset = line.normal.dot(mean);
  line.rms = std::sqrt(std::max(0.0, solver.eigenvalues()[0]));
  return line;
}

}  // namespace enfilade::perception
