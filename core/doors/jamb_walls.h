// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "core/doors/local_map.h"

namespace enfilade::doors {

// The wall that a door is a gap in: what runs on from both posts along one common straight line.
struct JambWalls {
  double left = 0.0;  // m of it beyond each post, without interruption
  double right = 0.0;
  double left_again = 0.0;  // m of it that are seen again behind one interruption: a pane of glass, another door
  double right_again = 0.0;
  // The wall ends at one that runs along the way before and behind it, as that of a door across a corridor does.
  bool left_cornered = false;
  bool right_cornered = false;
  // Where the line ends on either side, interruptions included, odometry frame.
  Eigen::Vector2d left_end = Eigen::Vector2d::Zero();
  Eigen::Vector2d right_end = Eigen::Vector2d::Zero();

  double beside() const { return left + right; }
  double length() const { return left + right + left_again + right_again; }
  // What is seen again counts half: it may be another thing that happens to stand there.
  double weighted_length() const { return beside() + (left_again + right_again) / 2.0; }
};

// m without a hit that do not end a wall which was seen from both sides.
inline constexpr double kMissingInWall = 0.2;

// Looks up to `limit` metres beyond each post. A door's posts are the ends of one wall, or of a wall and the corner
// that it meets; the posts of a narrow place that a corridor's openings make lie on two walls that run along the way,
// beside each other, and what stands about is short. The common line may be off the line between the posts by as much
// as the posts lie on a thick wall's two faces. `missing` metres without a hit do not end the wall.
JambWalls FindJambWalls(const LocalMap& map, const Eigen::Vector2d& left, const Eigen::Vector2d& right, double limit,
                        double missing = kMissingInWall);

// Walls that run beside the way past a narrow place instead of across it: how far, m, up to `limit`, straight surfaces
// run on from both posts in one common direction (or its reverse), 40 to 140 degrees off the line between them; the
// shorter of the two at the direction where that is longest. Beside a corridor's narrow place it is as long as the
// walls; at a door's two posts it is the wall's thickness, because a leaf that stands open or a corner is on one side.
double ParallelSurfaces(const LocalMap& map, const Eigen::Vector2d& left, const Eigen::Vector2d& right, double limit);

}  // namespace enfilade::doors
