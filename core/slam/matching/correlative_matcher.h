// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/geometry/pose2.h"
#include "core/slam/matching/search_table.h"

namespace enfilade::slam {

// Where to look: all poses within the half-widths about `centre`, and how much a pose away from it must score more.
struct SearchWindow {
  Pose2 centre;
  double half_width = 0.5;         // m, in x and in y
  double half_angle = 0.35;        // rad; pi and more: all headings
  double sigma_translation = 1e9;  // m
  double sigma_yaw = 1e9;          // rad
  double min_score = 0.0;          // what scores less is not looked for
  // Poses nearer than this to `excluded`, in both, are left out.
  std::optional<Pose2> excluded = std::nullopt;
  double excluded_distance = 0.0;  // m
  double excluded_angle = 0.0;     // rad
};

struct SearchResult {
  Pose2 pose;
  double score = 0.0;  // mean likelihood of the points, 0..1; 0 where nothing reaches the minimum
};

// The pose in the window with the largest  mean likelihood - kPriorWeight * (squared distance from the centre in
// sigmas), to a cell and to the angle at which the farthest points move by a cell: exhaustive, by branch and bound
// (Olson 2009 and 2015, Hess et al. 2016). `points` are in the robot's frame.
SearchResult SearchPose(const SearchTable& table, const std::vector<Eigen::Vector2d>& points,
                        const SearchWindow& window);

}  // namespace enfilade::slam
