// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <cstdint>
#include <string_view>

#include "core/geometry/pose2.h"

namespace enfilade::prior {

// Where a plan lies in a map: p_map = linear * p_sheet + offset, from the sheet's units to metres.
struct PlanTransform {
  Eigen::Matrix2d linear = Eigen::Vector2d(1, -1).asDiagonal();
  Eigen::Vector2d offset = Eigen::Vector2d::Zero();  // m

  Eigen::Vector2d operator()(const Eigen::Vector2d& point_sheet) const { return linear * point_sheet + offset; }
  // The sheet's y points down and the map's up, so that a plan that is drawn as it is built turns once.
  bool mirrored() const { return linear.determinant() > 0; }
  // m per unit, the geometric mean of both axes.
  double scale() const;
};

// Whether both axes have one scale and are at right angles.
bool IsSimilarity(const PlanTransform& transform);

// The similarity that turns and scales alike (the polar decomposition), and places `fixed_map`, m, alike.
PlanTransform AsSimilarity(const PlanTransform& T_map_sheet, const Eigen::Vector2d& fixed_map);

// The same point of the map, in the sheet.
Eigen::Vector2d ToSheet(const PlanTransform& T_map_sheet, const Eigen::Vector2d& point_map);

// The place in another frame of the map: T_other_map * T_map_sheet.
PlanTransform operator*(const Pose2& T_other_map, const PlanTransform& T_map_sheet);

// How a plan may be distorted as a whole.
enum class TransformModel : std::uint8_t {
  kRigid,        // turned only: its scale is known
  kSimilarity,   // turned and scaled
  kAnisotropic,  // and scaled otherwise along the sheet's y than along its x
  kAffine,       // and sheared
};
std::string_view NameOf(TransformModel model);
// Its free numbers: 3, 4, 5, 6.
int FreedomOf(TransformModel model);

}  // namespace enfilade::prior
