// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/geometry/pose2.h"
#include "core/slam/matching/search_table.h"

namespace enfilade::slam {

// Which poses to search: all within the half-widths about `centre`. The sigmas are those of the prior (see SearchPose).
struct SearchWindow {
  Pose2 centre;
  double half_width = 0.5;         // m, in x and in y
  double half_angle = 0.35;        // rad; pi or more: all headings
  double sigma_translation = 1e9;  // m
  double sigma_yaw = 1e9;          // rad
  double min_score = 0.0;          // poses that score less are not found
  // Nor need poses that score no more than this be found: the search may return any of them, or none.
  double relevant_score = 0.0;
  // Poses nearer than this to `excluded`, in both distance and angle, are left out.
  std::optional<Pose2> excluded = std::nullopt;
  double excluded_distance = 0.0;  // m
  double excluded_angle = 0.0;     // rad
};

struct SearchResult {
  Pose2 pose;
  double score = 0.0;  // mean likelihood of the points, 0..1; 0 if no pose reaches the minimum
};

// Correlative scan matching: the pose in the window with the largest
//   mean likelihood - kPriorWeight * (squared distance from the centre, in sigmas),
// to a resolution of one cell and of the angle at which the farthest points move by one cell. The result is that of the
// exhaustive search, found by branch and bound (Olson 2009 and 2015, Hess et al. 2016). `points` in the robot's frame.
SearchResult SearchPose(const SearchTable& table, const std::vector<Eigen::Vector2d>& points,
                        const SearchWindow& window);

}  // namespace enfilade::slam
