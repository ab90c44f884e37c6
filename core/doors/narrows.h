// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "core/doors/door_options.h"
#include "core/doors/local_map.h"

namespace enfilade::doors {

// A place where the way is narrow, and wider before and behind it: what a door is to a laser scanner.
struct Narrows {
  Eigen::Vector2d left = Eigen::Vector2d::Zero();  // the posts, odometry frame
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  double along = 0.0;  // m along the way, to where it crosses the line between the posts
  double depth = 0.0;  // m of the way that are about as narrow

  double width() const { return (left - right).norm(); }
  Eigen::Vector2d middle() const { return (left + right) / 2.0; }
};

struct NarrowsSearch {
  std::optional<Narrows> narrows;
  std::string reason;  // of the last place that was judged
};

// The part of a straight way between `begin` and `end` metres from the origin, odometry frame.
struct StraightWay {
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();
  Eigen::Vector2d direction = Eigen::Vector2d::UnitX();  // of length 1
  double begin = 0.0;
  double end = 0.0;
};

// The nearest narrow place that the way crosses. The width at each place of the way is the least distance between a
// surface on its left and one on its right whose connecting line crosses the way there; a door is a local minimum of
// it.
NarrowsSearch FindNarrows(const LocalMap& map, const StraightWay& way, const GapOptions& options);

}  // namespace enfilade::doors
