// SPDX-License-Identifier: Apache-2.0
#include "perception/cloud/surfels.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cstddef>

namespace enfilade::perception {
namespace {

constexpr double kThickness = 1e-3;  // of a plane relative to its extent

}  // namespace

Surfels MakeSurfels(const std::vector<Eigen::Vector3f>& points, const NearestPoints& tree, int neighbours) {
  Surfels surfels;
  surfels.points = points;
  surfels.covariances.reserve(points.size());
  surfels.normals.reserve(points.size());
  surfels.flatness.reserve(points.size());
  for (const Eigen::Vector3f& point : points) {
    const std::vector<int> near = tree.Neighbours(point, neighbours);
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const int i : near) mean += points[static_cast<std::size_t>(i)].cast<double>();
    mean /= static_cast<double>(std::max<std::size_t>(near.size(), 1));
    Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
    for (const int i : near) {
      const Eigen::Vector3d offset = points[static_cast<std::size_t>(i)].cast<double>() - mean;
      scatter += offset * offset.transpose();
    }
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
    solver.computeDirect(scatter);  // eigenvalues rise
    const Eigen::Matrix3d axes = solver.eigenvectors();
    surfels.covariances.emplace_back(axes * Eigen::Vector3d(kThickness, 1.0, 1.0).asDiagonal() * axes.transpose());
    surfels.normals.emplace_back(axes.col(0));
    const Eigen::Vector3d spread = solver.eigenvalues().cwiseMax(0.0).cwiseSqrt();
    surfels.flatness.push_back(spread.z() > 0.0 ? (spread.y() - spread.x()) / spread.z() : 0.0);
  }
  return surfels;
}

}  // namespace enfilade::perception
