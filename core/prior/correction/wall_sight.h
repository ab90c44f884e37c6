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

// Of each of the plan's `walls` (centre lines and faces, in the map's frame; faces name their wall). A piece of a wall
// is seen if the map has a wall there that runs as it does and belongs to no other wall of the plan. It is contradicted
// if the map knows free ground there, and has no wall nearby that runs as it does, or whose direction it does not know.
// A wall that stands at right angles, such as that at which an invented wall begins, or furniture that is straight does
// not make a piece seen.
std::vector<WallSight> SightsOf(const std::vector<WallFace>& lines, const std::vector<WallFace>& faces,
                                const MapEvidence& evidence);

}  // namespace enfilade::prior
