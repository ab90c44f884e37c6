// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "core/prior/alignment/map_evidence.h"
#include "core/prior/alignment/plan_transform.h"
#include "core/prior/alignment/wall_faces.h"

namespace enfilade::prior {

struct RefineOptions {
  TransformModel model = TransformModel::kSimilarity;
  // m: how far walls are sought, round by round, and how wide the kernel is.
  double widest = 2.0;
  double narrowest = 0.3;
  int rounds = 20;
  std::size_t most_points = 6000;
};

// Moves a plan onto the map's walls: iterated closest points to lines, with the direction of walls compared and a
// Geman-McClure kernel that narrows (Besl and McKay 1992; Chen and Medioni 1991; Zhou, Park, Koltun 2016: graduated
// non-convexity). Returns the start where too few walls are near.
PlanTransform Refine(const std::vector<WallFace>& faces_sheet, const MapEvidence& evidence, const PlanTransform& start,
                     const RefineOptions& options);

}  // namespace enfilade::prior
