// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/rooms/distance_field.h"
#include "core/rooms/ground.h"

namespace enfilade::rooms {

// The shortest line across a narrow place, from wall to wall. In cells.
struct DoorCandidate {
  Eigen::Vector2d a = Eigen::Vector2d::Zero();  // centres of the wall cells at its ends
  Eigen::Vector2d b = Eigen::Vector2d::Zero();
  bool passed = false;  // a robot is known to have driven through

  double length() const { return (b - a).norm(); }
  Eigen::Vector2d middle() const { return (a + b) / 2.0; }
};

// The candidate at a narrow place (basins.h). None: no wall stands opposite the nearest one, or the line is longer than
// `max_length` cells.
std::optional<DoorCandidate> CandidateAt(const GroundMap& ground, const DistanceField& field, std::size_t place,
                                         double max_length);

// What the walls say about a candidate, in metres.
struct JambEvidence {
  double slender = 0.0;    // of a thin wall that continues the line beyond the jamb, open ground on both sides
  double facing = 0.0;     // of a wall that continues the line, open ground on one side, nothing seen on the other
  double thickness = 0.0;  // mean, of the slender wall
  // How far, up to 1 m, a wall runs from the jamb across the line, on either side of the door.
  double across_before = 0.0;
  double across_behind = 0.0;
  Eigen::Vector2d wall_from = Eigen::Vector2d::Zero();       // the line that continues, cells
  Eigen::Vector2d wall_direction = Eigen::Vector2d::Zero();  // away from the door
  double seen = 0.0;     // share of the obstacle at the jamb that is wall, not unknown
  double farther = 0.0;  // of thin walls on the same line within 5 m, interruptions included
  double extent = 0.0;   // of the group of wall cells at the jamb, up to 4 m
};

struct DoorEvidence {
  double width = 0.0;  // of the longest stretch that nothing stands on
  JambEvidence a;
  JambEvidence b;
  // How much wider the open ground is than the door, 0.5 m before and behind it; up to 2 m.
  double wider_before = 0.0;
  double wider_behind = 0.0;
  double aligned = 0.0;  // share of the straight walls within 2.5 m that run along or across the line
};

// As numbers: what the weights of OpennessOf are fitted to.
std::vector<double> ValuesOf(const DoorEvidence& evidence);

DoorEvidence GatherEvidence(const GroundMap& ground, const DoorCandidate& candidate);

// Where the walls that end at a candidate's jambs meet the next wall if they are continued across the opening:
// furniture beside a door may be nearer to one jamb than the other jamb is.
std::vector<DoorCandidate> ContinueWalls(const GroundMap& ground, const DoorCandidate& line,
                                         const DoorEvidence& evidence, double max_length);

// The logarithm of the odds that the candidate is open ground (positive) against a door (negative).
double OpennessOf(const DoorEvidence& evidence);

}  // namespace enfilade::rooms
