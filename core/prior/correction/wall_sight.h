// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/prior/alignment/agreement.h"
#include "core/prior/alignment/map_evidence.h"
#include "core/prior/alignment/wall_faces.h"

namespace enfilade::prior {

// What a map says of one wall of a plan.
struct WallSight {
  Sight sight = Sight::kUnseen;  // of most of it
  double seen_share = 0;         // of its length
  double contradicted_share = 0;
};

// Of each of the plan's `walls` (centre lines and faces, in the map's frame; faces name their wall). A wall is seen or
// not as a whole: along the straight line that the map supports best (LikeliestLine), more of it must be on walls of
// the map than in free ground. A wall of the map counts if it runs as this one does and belongs to no other of the
// plan. A piece is contradicted if the map knows free ground there and has no wall nearby that runs so, or whose
// direction it does not know; a wall, if half of it is known, most of that is contradicted, and it is longer than
// kSeenDistance.
std::vector<WallSight> SightsOf(const std::vector<WallFace>& lines, const std::vector<WallFace>& faces,
                                const MapEvidence& evidence);

}  // namespace enfilade::prior
