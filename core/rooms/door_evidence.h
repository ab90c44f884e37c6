// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstddef>

#include "core/rooms/door_candidate.h"
#include "core/rooms/ground.h"

namespace enfilade::rooms {

// What the walls say about one end of a candidate, in metres.
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
  double width = 0.0;   // m, of the longest stretch that nothing stands on
  double length = 0.0;  // m, from wall to wall
  JambEvidence a;
  JambEvidence b;
  // How much wider the open ground is than the door, 0.5 m before and behind it; up to 2 m.
  double wider_before = 0.0;
  double wider_behind = 0.0;
  double aligned = 0.0;  // share of the straight walls within 2.5 m that run along or across the line
  // What robots' door detectors say (passage_silence.h).
  int reports = 0;       // passages reported at the line
  double silence = 0.0;  // minus the logarithm of how likely a door would have been passed without a report so often
};

DoorEvidence GatherEvidence(const GroundMap& ground, const DoorCandidate& candidate);

// The wall that goes on from a jamb, `outward` along the candidate's line. In cells.
JambEvidence JambAt(const GroundMap& ground, const Eigen::Vector2d& jamb, const Eigen::Vector2d& outward);

// How much wider the ground is than a line 0.5 m before it (`sign` 1) or behind it (-1), up to 1 m at each end; m. It
// ends at cells that are not free(cell).
template <typename Free>
double WidthBeyond(const GroundMap& ground, const DoorCandidate& line, double sign, Free&& free) {
  constexpr double kAside = 0.5;  // m
  constexpr double kMost = 1.0;   // m
  const Eigen::Vector2d along = (line.b - line.a).normalized();
  const Eigen::Vector2d aside(-along.y(), along.x());
  const Eigen::Vector2d at = line.middle() + sign * (kAside / ground.resolution * aside);
  const double most = line.length() / 2.0 + kMost / ground.resolution;
  double width = 0.0;
  for (const double direction : {-1.0, 1.0}) {
    double reached = 0.0;
    while (reached < most) {
      const Eigen::Vector2d p = at + direction * (reached + 1.0) * along;
      const auto x = static_cast<int>(std::lround(p.x()));
      const auto y = static_cast<int>(std::lround(p.y()));
      if (!ground.contains(x, y) || !free(ground.index(x, y))) break;
      reached += 1.0;
    }
    width += reached;
  }
  return (width - line.length()) * ground.resolution;
}

// The evidence as numbers that depend neither on which jamb is `a` nor on which side is before the line: what the odds
// are fitted to (door_odds.h).
using DoorValues = std::array<double, 27>;
DoorValues ValuesOf(const DoorEvidence& evidence);

}  // namespace enfilade::rooms
