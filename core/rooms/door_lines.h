// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "core/grid/occupancy_grid.h"
#include "core/rooms/door_candidate.h"
#include "core/rooms/door_evidence.h"
#include "core/rooms/ground.h"
#include "core/rooms/room_options.h"
#include "core/rooms/room_partition.h"

namespace enfilade::rooms {

class DoorOdds;

// A candidate and what is thought of it.
struct DoorLine {
  DoorCandidate line;
  DoorEvidence evidence;
  double openness = 0.0;  // DoorOdds
};

// The lines along which the ground may be cut: at narrow places, and where robots are known to have passed a door.
std::vector<DoorLine> FindDoorLines(const GroundMap& ground, const DistanceField& field, const RoomOptions& options,
                                    const DoorOdds& odds);

// The narrow places of the robots' ways (path_narrows.h), doors or not, but for those that are among the `known` lines.
std::vector<DoorLine> JudgeNarrowsOnPath(const GroundMap& ground, const grid::GridGeometry& geometry,
                                         std::span<const Eigen::Vector2d> trajectory, const RoomOptions& options,
                                         const DoorOdds& odds, const std::vector<DoorLine>& known);

// Adds those of them that are doors, instead of the less clear lines across the same openings.
void AddNarrowsOnPath(const GroundMap& ground, const grid::GridGeometry& geometry,
                      std::span<const Eigen::Vector2d> trajectory, const RoomOptions& options, const DoorOdds& odds,
                      std::vector<DoorLine>& lines);

// A passage is evidence for the line nearest to it, or is a line itself.
void AddPassages(const GroundMap& ground, const grid::GridGeometry& geometry, std::span<const PassageHint> passages,
                 const RoomOptions& options, const DoorOdds& odds, std::vector<DoorLine>& lines);

// What a line says about the regions on its sides: for joining them (positive) or against it, as the logarithm of odds.
// That it is open says less the less of its jambs was seen, and little where no robot fits through: scans leave holes
// in walls. However open, it outweighs one clear door. `robot_radius` in m.
double JoinWeight(const DoorLine& line, double robot_radius);

}  // namespace enfilade::rooms
