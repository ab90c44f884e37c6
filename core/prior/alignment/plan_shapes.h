// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/prior/alignment/map_evidence.h"
#include "core/prior/alignment/plan_transform.h"
#include "core/prior/alignment/wall_faces.h"

namespace enfilade::prior {

// How a plan may lie in a map, apart from its offset.
struct PlanShape {
  Eigen::Matrix2d linear = Eigen::Matrix2d::Identity();  // from the sheet's units to metres
  TransformModel model = TransformModel::kSimilarity;
};

enum class Stretch : std::uint8_t {
  kNone,        // both axes have one scale
  kAlongWalls,  // plans are stretched along their walls, and by no more than a quarter
};

// All turns that bring the directions of walls together, straight and mirrored, at all `scales` (m per unit).
std::vector<PlanShape> ShapesToTry(const std::vector<WallFace>& faces_sheet, const MapEvidence& evidence,
                                   const std::vector<double>& scales, Stretch stretch);
// Of a shape that is known: all turns of it, as mirrored as it is, at `scales` by which its own is multiplied.
std::vector<PlanShape> TurnsOf(const PlanTransform& known_shape, const std::vector<WallFace>& faces_sheet,
                               const MapEvidence& evidence, const std::vector<double>& scales);

}  // namespace enfilade::prior
