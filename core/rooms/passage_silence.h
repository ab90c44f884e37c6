// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "core/grid/occupancy_grid.h"
#include "core/rooms/door_lines.h"
#include "core/rooms/door_odds.h"
#include "core/rooms/room_partition.h"

namespace enfilade::rooms {

// Robots that have gone across a line again and again without a report of their door detector were hardly in a door.
// Sets DoorEvidence::silence and judges the lines anew. How often a detector reports a door is estimated from the lines
// that are clearly doors by their walls. Without any report nothing changes: there may be no detector. Points of the
// trajectory up to kLongestStep apart are joined (path_narrows.h).
void WeighSilence(const grid::GridGeometry& geometry, const RoomEvidence& evidence, const DoorOdds& odds,
                  std::vector<DoorLine>& lines);

// m, 0 without a passage. Detectors look for doors up to some width, and say nothing of wider lines. A line may be a
// little wider than what they measure: it ends on the walls' cells.
double WidestReported(std::span<const PassageHint> passages);

}  // namespace enfilade::rooms
