// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/slam/matching/likelihood_field.h"
#include "core/slam/matching/scan_matcher.h"
#include "core/slam/matching/search_table.h"
#include "core/slam/slam_options.h"
#include "core/slam/submaps/submap_grid.h"

namespace enfilade::slam {

// A finished submap as loop closing sees it: its likelihood field at resolutions from low to high, and the table for
// searching poses over all of it.
struct FieldPyramid {
  std::vector<LikelihoodField> levels;  // from the coarsest to the submap's own resolution
  SearchTable table;

  FieldPyramid(const SubmapGrid& grid, const PyramidOptions& options);

  // Bytes of memory held.
  std::size_t bytes() const;
};

struct PyramidMatch {
  MatchResult match;  // at the last level that was tried
  bool inliers_suffice = false;
  std::string reason;  // where they do not: which share failed which floor at which resolution
};

// Refines `guess` level by level, each level beginning where the one before ended, with a robust kernel as wide as the
// level's cells. Stops where too few of the points are inliers: a floor at the coarsest level, where even a poor
// guess must fit, rising to the full demand at the finest (seed 001).
PyramidMatch MatchToPyramid(const FieldPyramid& pyramid, const std::vector<Eigen::Vector2d>& points, const Pose2& guess,
                            const PyramidOptions& options, const FieldMatchOptions& field);

}  // namespace enfilade::slam
