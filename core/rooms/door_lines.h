// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "core/grid/occupancy_grid.h"
#include "core/rooms/distance_field.h"
#include "core/rooms/door_candidate.h"
#include "core/rooms/door_evidence.h"
#include "core/rooms/ground.h"
#include "core/rooms/room_options.h"
#include "core/rooms/room_partition.h"

namespace enfilade::rooms {

// A candidate and what is thought of it.
struct DoorLine {
  DoorCandidate line;
  DoorEvidence evidence;
  double openness = 0.0;  // door_odds.h
};

// m, from wall to wall: a door may have panes of glass beside it.
double LongestLine(const RoomOptions& options);

// One of the lines has its ends, in either order, less than `same` cells from the candidate's.
bool IsKnown(const DoorCandidate& candidate, double same, const std::vector<DoorLine>& lines);

// The lines along which the ground may be cut: at narrow places, and where robots are known to have passed a door.
std::vector<DoorLine> FindDoorLines(const GroundMap& ground, const DistanceField& field, const RoomOptions& options);

// Adds the narrow places of the robots' ways (path_narrows.h) that are doors, instead of lines near them
// that are less so.
void AddNarrowsOnPath(const GroundMap& ground, const grid::GridGeometry& geometry,
                      std::span<const Eigen::Vector2d> trajectory, const RoomOptions& options,
                      std::vector<DoorLine>& lines);

// A passage makes the line nearest to it a door, or is a line itself.
void AddPassages(const GroundMap& ground, const grid::GridGeometry& geometry, std::span<const PassageHint> passages,
                 std::vector<DoorLine>& lines);

}  // namespace enfilade::rooms
