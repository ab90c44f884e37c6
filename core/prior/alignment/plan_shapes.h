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
  kNone,        // both axes have the same scale
  kAlongWalls,  // the scale along the walls of one direction is a quarter larger than across them
};

// All turns that bring the directions of walls together, straight and mirrored, at all `scales` (m per unit).
std::vector<PlanShape> ShapesToTry(const std::vector<WallFace>& faces_sheet, const MapEvidence& evidence,
                                   const std::vector<double>& scales, Stretch stretch);

// The same of a known shape, which stays stretched and mirrored as it is. `scales` multiply its own.
std::vector<PlanShape> TurnsOf(const PlanTransform& known_shape, const std::vector<WallFace>& faces_sheet,
                               const MapEvidence& evidence, const std::vector<double>& scales);

}  // namespace enfilade::prior
