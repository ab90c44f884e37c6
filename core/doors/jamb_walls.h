// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "core/doors/local_map.h"

namespace enfilade::doors {

// The wall that a door is a gap in: it continues from both posts along one common straight line.
struct JambWalls {
  double left = 0.0;  // m of it beyond each post, without interruption
  double right = 0.0;
  double left_again = 0.0;  // m of it that continue behind one interruption: a pane of glass, another door
  double right_again = 0.0;
  // The wall ends at a wall that runs along the way before and behind it: a door across a corridor.
  bool left_cornered = false;
  bool right_cornered = false;
  // The ends of the line, interruptions included, odometry frame.
  Eigen::Vector2d left_end = Eigen::Vector2d::Zero();
  Eigen::Vector2d right_end = Eigen::Vector2d::Zero();

  double beside() const { return left + right; }
  double length() const { return left + right + left_again + right_again; }
  // What continues behind an interruption counts half: it may be something else that stands there.
  double weighted_length() const { return beside() + (left_again + right_again) / 2.0; }
};

// A gap of up to this many metres without a hit does not end a wall that was seen from both sides.
inline constexpr double kMissingInWall = 0.2;

// Follows the wall up to `limit` metres beyond each post. A door's posts are the ends of one wall, or of a wall and the
// corner that it meets. The posts of a narrow place between a corridor's openings lie on two walls that run along the
// way, and furniture is short. The common line may differ from the line between the posts, which may lie on the two
// faces of a thick wall. A gap of `missing` metres without a hit does not end the wall.
JambWalls FindJambWalls(const LocalMap& map, const Eigen::Vector2d& left, const Eigen::Vector2d& right, double limit,
                        double missing = kMissingInWall);

// The length of walls that run beside the way past a narrow place instead of across it: how far, m, up to `limit`,
// straight surfaces continue from both posts in one common direction (or its reverse), 40 to 140 degrees off the line
// between them. Of the two the shorter counts, in the direction in which it is longest. At a narrow place of a corridor
// it is the length of the walls; at a door it is the wall's thickness, because an open leaf or a corner is on one side.
double ParallelSurfaces(const LocalMap& map, const Eigen::Vector2d& left, const Eigen::Vector2d& right, double limit);

}  // namespace enfilade::doors
