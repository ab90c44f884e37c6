// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "core/doors/door_options.h"
#include "core/doors/local_map.h"

namespace enfilade::doors {

// A place where the way is narrow and wider before and behind: what a door is to a laser scanner.
struct Narrows {
  Eigen::Vector2d left = Eigen::Vector2d::Zero();  // the posts, odometry frame
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  double along = 0.0;  // m along the way, where it crosses the line between the posts
  double depth = 0.0;  // m along the way over which it is about as narrow

  double width() const { return (left - right).norm(); }
  Eigen::Vector2d middle() const { return (left + right) / 2.0; }
};

struct NarrowsSearch {
  std::optional<Narrows> narrows;
  std::string reason;  // why there is none
};

// The nearest narrows that the way from `origin` along the unit vector `direction` crosses between `begin` and `end`
// metres on. The width at each place of the way is the least distance between anything on its left and anything on its
// right whose connecting line crosses the way there; a door is a local minimum of it.
NarrowsSearch FindNarrows(const LocalMap& map, const Eigen::Vector2d& origin, const Eigen::Vector2d& direction,
                          double begin, double end, const GapOptions& options);

}  // namespace enfilade::doors
