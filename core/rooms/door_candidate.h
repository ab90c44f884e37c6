// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/rooms/ground.h"

namespace enfilade::rooms {

struct DoorEvidence;

// The shortest line across a narrow place, from wall to wall. In cells.
struct DoorCandidate {
  Eigen::Vector2d a = Eigen::Vector2d::Zero();  // centres of the wall cells at its ends
  Eigen::Vector2d b = Eigen::Vector2d::Zero();

  double length() const { return (b - a).norm(); }
  Eigen::Vector2d middle() const { return (a + b) / 2.0; }
};

// The candidate at a narrow place (basins.h). None: no wall stands opposite the nearest one, or the line is longer than
// `max_length` cells.
std::optional<DoorCandidate> CandidateAt(const GroundMap& ground, const DistanceField& field, std::size_t place,
                                         double max_length);

// Where the walls that end at a candidate's jambs meet the next wall if they are continued across the opening:
// furniture beside a door may be nearer to one jamb than the other jamb is.
std::vector<DoorCandidate> ContinueWalls(const GroundMap& ground, const DoorCandidate& line,
                                         const DoorEvidence& evidence, double max_length);

// The lines from the candidate's ends across the opening in the directions of the walls around it: the shortest line is
// oblique where the jambs are not opposite each other.
std::vector<DoorCandidate> AlignWithWalls(const GroundMap& ground, const DoorCandidate& line, double max_length);

// The most frequent direction of straight walls around `at`, radians modulo a right angle; unset without walls.
std::optional<double> WallDirectionNear(const GroundMap& ground, const Eigen::Vector2d& at);

bool Crosses(const DoorCandidate& one, const DoorCandidate& other);

// They lie in about the same direction, less than `apart` cells from each other.
bool LieTogether(const DoorCandidate& one, const DoorCandidate& other, double apart);

// The line goes along `passage` and may go on beyond its ends: a door with a pane of glass beside it.
bool GoesAlong(const DoorCandidate& line, const DoorCandidate& passage);

}  // namespace enfilade::rooms
