// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/grid/occupancy_grid.h"
#include "core/rooms/door_lines.h"
#include "core/rooms/ground.h"

namespace enfilade::rooms {

// Robots that have gone across a line again and again without a report of their door detector were hardly in a door.
// Sets DoorEvidence::silence and judges the lines anew. How often a detector reports a door is estimated from the lines
// that are clearly doors by their walls, so no reports at all say nothing: there may be no detector. `trajectory`:
// where robots have been, map frame, m, in order; points of up to 1 m apart are joined.
void WeighSilence(const grid::GridGeometry& geometry, const RoomEvidence& evidence, std::vector<DoorLine>& lines);

}  // namespace enfilade::rooms
