// SPDX-License-Identifier: Apache-2.0
#include "core/prior/localization/ndt_map.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace enfilade::prior {
namespace {

struct Sums {
  int count = 0;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
};

NdtCell CellFrom(const Sums& sums) {
  NdtCell cell;
  cell.points = sums.count;
  cell.mean = sums.sum / sums.count;
  const Eigen::Matrix2d scatter = sums.squares - sums.count * cell.mean * cell.mean.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(scatter / (sums.count - 1));
  Eigen::Vector2d variances = solver.eigenvalues();  // rising
  variances.y() = std::max(variances.y(), 1e-6);
  variances.x() = std::max(variances.x(), kThinnest * variances.y());
  cell.covariance = solver.eigenvectors() * variances.asDiagonal() * solver.eigenvectors().transpose();
  return cell;
}

}  // namespace

std::vector<NdtCell> NdtOf(const std::vector<Eigen::Vector2d>& points, double side) {
  std::map<std::pair<int, int>, Sums> cells;
  for (const Eigen::Vector2d& point : points) {
    Sums& sums =
        cells[{static_cast<int>(std::floor(point.y() / side)), static_cast<int>(std::floor(point.x() / side))}];
    ++sums.count;
    sums.sum += point;
    sums.squares += point * point.transpose();
  }
  std::vector<NdtCell> result;
  for (const auto& [key, sums] : cells) {
    if (sums.count >= kFewestNdtPoints) result.push_back(CellFrom(sums));
  }
  return result;
}

}  // namespace enfilade::prior
