// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/prior/alignment/map_evidence.h"
#include "core/prior/alignment/plan_transform.h"
#include "core/prior/alignment/wall_faces.h"

namespace enfilade::prior {

struct PlacedModel {
  PlanTransform T_map_sheet;
  TransformModel model = TransformModel::kSimilarity;
};

// Which distortion of the plan as a whole the map's walls bear out, from a place that is about right: a similarity, one
// scale for each axis, or an affine transform. The walls are divided into blocks by where they are. Each block is held
// back in turn, the model is fitted to all others (Refine), and judged by what it leaves of that block: what was not
// looked at lies elsewhere, too (spatial cross-validation; D. Roberts et al., "Cross-validation strategies for data
// with temporal, spatial, hierarchical, or phylogenetic structure", 2017). More freedom is taken if it leaves less by
// more than the standard error of the difference (Breiman et al., "Classification and regression trees", 1984). The
// result is fitted to all walls.
PlacedModel ChooseModel(const std::vector<WallFace>& faces_sheet, const MapEvidence& evidence, const PlacedModel& start,
                        TransformModel widest);

}  // namespace enfilade::prior
