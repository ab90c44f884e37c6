// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

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
};

struct DoorEvidence {
  double width = 0.0;
  JambEvidence a;
  JambEvidence b;
  // How much wider the open ground is than the door, 0.5 m before and behind it; up to 2 m.
  double wider_before = 0.0;
  double wider_behind = 0.0;
};

DoorEvidence GatherEvidence(const GroundMap& ground, const DoorCandidate& candidate);

// The logarithm of the odds that the candidate is open ground (positive) against a door (negative).
double OpennessOf(const DoorEvidence& evidence);

}  // namespace enfilade::rooms
