// SPDX-License-Identifier: Apache-2.0
#include "core/slam/submaps/robot_rays.h"

#include <cmath>

namespace enfilade::slam {
namespace {

// Not inlined: GCC 12 vectorises the loops below two points at a time and forgets the last of an odd number.
[[gnu::noinline]] double ToSinglePrecision(double value) { return static_cast<double>(static_cast<float>(value)); }

Eigen::Vector2d Rounded(const Eigen::Vector2d& p) { return {ToSinglePrecision(p.x()), ToSinglePrecision(p.y())}; }

}  // namespace

grid::ScanRays RobotRays(const sensor::LaserScan& scan, const grid::ScanRayOptions& options) {
  grid::ScanRays rays = grid::RaysOf(scan, Pose2{}, options);
  rays.origin = Rounded(rays.origin);
  for (Eigen::Vector2d& p : rays.hits) p = Rounded(p);
  for (Eigen::Vector2d& p : rays.free_ends) p = Rounded(p);
  return rays;
}

grid::ScanRays Transformed(const Pose2& T_target_source, const grid::ScanRays& rays) {
  Eigen::Matrix2d R;
  R << std::cos(T_target_source.yaw), -std::sin(T_target_source.yaw), std::sin(T_target_source.yaw),
      std::cos(T_target_source.yaw);
  const Eigen::Vector2d t = T_target_source.translation();
  grid::ScanRays result;
  result.origin = R * rays.origin + t;
  result.hits.reserve(rays.hits.size());
  for (const Eigen::Vector2d& p : rays.hits) result.hits.emplace_back(R * p + t);
  result.free_ends.reserve(rays.free_ends.size());
  for (const Eigen::Vector2d& p : rays.free_ends) result.free_ends.emplace_back(R * p + t);
  return result;
}

}  // namespace enfilade::slam
