// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/prior/alignment/map_evidence.h"
#include "core/prior/alignment/wall_faces.h"

namespace enfilade::prior {

// How far the plan may be turned, modulo 90 degrees, so that its walls have the directions of the map's: the angle that
// is added to the direction of a wall of the plan (with y up; mirrored at the x axis if `mirrored`), rad in [0, pi /
// 2), the most likely first, three at most. Found by correlating both histograms of directions, weighted by length,
// because the wings of a building may have directions of their own.
std::vector<double> LikelyTurns(const std::vector<WallFace>& faces_sheet, const MapEvidence& evidence, bool mirrored);

// The direction of most walls of the plan in its sheet, modulo 90 degrees: rad in [0, pi / 2).
double MainDirection(const std::vector<WallFace>& faces_sheet);

}  // namespace enfilade::prior
