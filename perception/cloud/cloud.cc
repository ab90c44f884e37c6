// SPDX-License-Identifier: Apache-2.0
#include "perception/cloud/cloud.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "core/base/error.h"

namespace enfilade::perception {
namespace {

constexpr double kMaxCell = 1 << 20;  // 21 bits a coordinate

std::uint64_t KeyOf(const Eigen::Vector3d& cell) {
  const auto bits = [](double coordinate) { return static_cast<std::uint64_t>(coordinate + kMaxCell); };
  return bits(cell.z()) << 42 | bits(cell.y()) << 21 | bits(cell.x());
}

}  // namespace

Cloud FinitePoints(const Cloud& cloud) {
  Cloud finite;
  finite.points.reserve(cloud.points.size());
  for (const Eigen::Vector3f& point : cloud.points) {
    if (point.allFinite()) finite.points.push_back(point);
  }
  return finite;
}

Cloud Transformed(const Cloud& cloud, const Eigen::Isometry3d& T_to_from) {
  Cloud result;
  result.points.reserve(cloud.points.size());
  for (const Eigen::Vector3f& point : cloud.points) {
    result.points.push_back((T_to_from * point.cast<double>()).cast<float>());
  }
  return result;
}

absl::StatusOr<Cloud> VoxelFilter(const Cloud& cloud, double voxel) {
  if (!(voxel > 0.0) || !std::isfinite(voxel)) return InvalidArgument("voxel is {}: expected positive metres", voxel);
  std::vector<std::pair<std::uint64_t, std::uint32_t>> cells;
  cells.reserve(cloud.points.size());
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    if (!cloud.points[i].allFinite()) continue;
    const Eigen::Vector3d cell = (cloud.points[i].cast<double>() / voxel).array().floor();
    if (cell.cwiseAbs().maxCoeff() >= kMaxCell) {
      return InvalidArgument("point {} at ({}, {}, {}) m is too far away for voxels of {} m", i, cloud.points[i].x(),
                             cloud.points[i].y(), cloud.points[i].z(), voxel);
    }
    cells.emplace_back(KeyOf(cell), static_cast<std::uint32_t>(i));
  }
  std::sort(cells.begin(), cells.end());
  Cloud filtered;
  for (std::size_t first = 0; first < cells.size();) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    std::size_t next = first;
    for (; next < cells.size() && cells[next].first == cells[first].first; ++next) {
      sum += cloud.points[cells[next].second].cast<double>();
    }
    filtered.points.push_back((sum / static_cast<double>(next - first)).cast<float>());
    first = next;
  }
  return filtered;
}

}  // namespace enfilade::perception
