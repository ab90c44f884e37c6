// SPDX-License-Identifier: Apache-2.0
#include "core/localization/alignment/map_fit.h"

#include <limits>
#include <vector>

namespace enfilade::localization {
namespace {

constexpr double kBeforeSurface = 0.2;  // m

}  // namespace

bool IsSeenFromTheSameSide(const AlignableMap& map, const Pose2& T_map_points, const SurfacePoint& surface) {
  return map.searchable().At(T_map_points * (surface.point + kBeforeSurface * surface.open)) ==
         SearchableMap::Cell::kFree;
}

SurfaceFit CompareSurfaces(const AlignableMap& map, const AlignableMap& other, const Pose2& T_map_other) {
  SurfaceFit fit;
  for (const SurfacePoint& surface : other.surfaces()) {
    const Eigen::Vector2d at = T_map_other * surface.point;
    const SearchableMap::Cell cell = map.searchable().At(at);
    if (cell == SearchableMap::Cell::kUnknown && !IsSeenFromTheSameSide(map, T_map_other, surface)) continue;
    const double squared_distance = map.searchable().walls().At(at).squared_distance;
    if (squared_distance > kOnWall * kOnWall) {
      if (cell == SearchableMap::Cell::kFree) fit.contradicted += other.resolution();
    } else if (surface.open.isZero() || IsSeenFromTheSameSide(map, T_map_other, surface)) {
      fit.matched += other.resolution();
    }
  }
  return fit;
}

MapFit CompareMaps(const AlignableMap& a, const AlignableMap& b, const Pose2& T_a_b) {
  return {CompareSurfaces(a, b, T_a_b), CompareSurfaces(b, a, Inverse(T_a_b))};
}

CommonGround CommonGroundOf(const AlignableMap& a, const AlignableMap& b, const Pose2& T_a_b) {
  std::vector<Eigen::Vector2d> common;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& point_b : b.ground()) {
    const Eigen::Vector2d point = T_a_b * point_b;
    if (a.searchable().At(point) != SearchableMap::Cell::kFree) continue;
    common.push_back(point);
    sum += point;
  }
  CommonGround ground;
  if (common.empty()) return ground;
  ground.area = static_cast<double>(common.size()) * AlignableMap::kGroundSpacing * AlignableMap::kGroundSpacing;
  const Eigen::Vector2d centroid = sum / static_cast<double>(common.size());
  double nearest = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector2d& point : common) {
    if ((point - centroid).squaredNorm() >= nearest) continue;
    nearest = (point - centroid).squaredNorm();
    ground.middle = point;
  }
  return ground;
}

}  // namespace enfilade::localization
